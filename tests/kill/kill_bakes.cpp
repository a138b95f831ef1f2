// SPDX-License-Identifier: Apache-2.0
// Bakes that are killed, interrupted, or meet in one folder: kill_bakes [KILLS [SEED]]
#include <cstdio>
#include <map>
#include <random>

#include "sim/cache/own_files.h"
#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

int kills_wanted = 10;
unsigned seed = 1;

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

class Kill : public BakeTest {
 protected:
  double random(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  // Until one more than so many frames are kept.
  static void await_frame(const fs::path& out, BakeProcess& bake, size_t frames) {
    const auto manifest = out / "bake.parts/manifest.jsonl";
    const auto lines = [&] {
      const std::string text = bytes_of(manifest);
      return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
    };
    while (!bake.ended() && lines() <= frames) sleep_for(0.001);
  }

  static std::map<std::string, std::string> pictures(const fs::path& out) {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::directory_iterator(out / "frames")) {
      const std::string name = entry.path().filename();
      if (name.ends_with(".png")) found[name] = bytes_of(entry.path());
    }
    return found;
  }

  std::mt19937 random_{seed};
};

TEST_F(Kill, NoCompletedFrameIsLost) {
  std::printf("%d kills, seed %u\n", kills_wanted, seed);
  const fs::path out = root_ / "killed";
  int bakes = 0, before_frames = 0, among_frames = 0, after_frames = 0, resumed = 0;
  std::vector<int> kept;
  for (int kills = 0; kills < kills_wanted && !HasFailure();) {
    // Every fourth bake draws pictures; those of a killed one are drawn again or kept.
    const bool draws = bakes % 4 == 3;
    BakeProcess bake(out, draws ? std::vector<std::string>{"--resume"}
                                : std::vector<std::string>{"--resume", "--no-render"});
    // Any instant at all, or any after the next frame, however slow the machine is just now.
    const double instant = random(0.0, (draws ? 2.0 : 1.05) * seconds_ / (1 + kills % 2));
    if (kills % 2 == 1) await_frame(out, bake, kept.size());
    sleep_for(instant);
    const bool complete = fs::exists(out / "bake.h5");
    bake.send(SIGKILL);
    const auto ended = bake.wait();
    if (ended.code == 0) {
      expect_whole(out);
      fs::remove_all(out);
      kept.clear();
      ++bakes;
      continue;
    }
    ASSERT_EQ(ended.code, -SIGKILL) << "at " << instant << " s: " << ended.errors;
    ++kills;
    if (complete || fs::exists(out / "bake.h5")) {
      ++after_frames;
      EXPECT_TRUE(bytes_of(out / "bake.h5") == whole_) << "at " << instant << " s";
      continue;
    }
    const std::vector<int> now = kept_frames(out);
    EXPECT_TRUE(begins_with(now, kept))
        << "killed at " << instant << " s: " << kept.size() << " frames before, " << now.size();
    (now.empty() ? before_frames : among_frames) += 1;
    resumed += !kept.empty();
    kept = now;
  }
  resume(out);
  std::printf("killed before the first frame %d, among frames %d, after the last %d; resumed %d\n",
              before_frames, among_frames, after_frames, resumed);
  EXPECT_GT(among_frames, kills_wanted / 4);
}

// What processes left that are no more, and nothing else: neither what a living one is writing, nor
// a user's files, whatever they are called.
TEST_F(Kill, WhatTheDeadLeftIsTakenAway) {
  const fs::path out = root_ / "left";
  resume(out);
  fs::create_directories(out / "frames");
  const Temporary alive(out / "frames/skin.0001.png");
  const std::vector<fs::path> users = {out / "frames/skin.mp4.tmp", out / "frames/skin.mp4.list",
                                       out / "bake.h5.tmp",         out / "frames/.thew-mine.tmp",
                                       out / "frames/muscles.png",  alive.path};
  for (const fs::path& file : users) std::ofstream(file) << "mine";
  for (const bool draws : {false, true}) {
    const pid_t dead = fork();
    if (dead == 0) {
      for (const char* name : {"report.html", "frames/skin.mp4", "frames/skin.0001.png"}) {
        std::ofstream((new Temporary(out / name))->path) << "half";  // and is killed
      }
      _exit(0);
    }
    waitpid(dead, nullptr, 0);
    EXPECT_EQ(temporary_files(out).size(), 3u + 2u);
    const auto ended = BakeProcess(out, draws ? std::vector<std::string>{"--resume"}
                                              : std::vector<std::string>{"--resume", "--no-render"})
                           .wait();
    EXPECT_EQ(ended.code, 0) << ended.errors;
    EXPECT_EQ(temporary_files(out).size(), 2u);
    for (const fs::path& file : users) EXPECT_EQ(bytes_of(file), "mine") << file;
  }
}

// Whenever the kill came: each picture is whole and of its frame, those that were done are kept.
TEST_F(Kill, PicturesAreThoseOfACalmBake) {
  const fs::path calm = root_ / "calm", out = root_ / "drawn";
  ASSERT_EQ(BakeProcess(calm, {}).wait().code, 0);
  const auto expected = pictures(calm);
  ASSERT_GT(expected.size(), 10u);
  int whole = 0;
  for (int kills = 0; kills < kills_wanted; ++kills) {
    {
      BakeProcess bake(out, {});
      sleep_for(random(0.0, 3.0 * seconds_));
      bake.send(SIGKILL);
      bake.wait();
    }
    if (fs::exists(out / "frames")) {
      for (const auto& [name, bytes] : pictures(out)) {
        EXPECT_TRUE(bytes == expected.at(name)) << name;
        ++whole;
      }
    }
  }
  const auto ended = BakeProcess(out, {}).wait();
  EXPECT_EQ(ended.code, 0) << ended.errors;
  expect_whole(out);
  EXPECT_TRUE(pictures(out) == expected);
  std::printf("%d pictures stood after the kills\n", whole);
}

// Interrupts a bake by a signal, which it answers by saying what to do. False if it ended before.
bool interrupt(int signal, const fs::path& out, BakeProcess& bake) {
  bake.send(signal);
  const auto ended = bake.wait();
  if (ended.code == 0) return false;
  EXPECT_EQ(ended.code, 75) << ended.errors;
  EXPECT_EQ(ended.errors, "thew: interrupted; run again with --resume\n");
  EXPECT_TRUE(temporary_files(out).empty());
  return true;
}

// They are drawn beside the frames: a signal ends both, and no completed frame is without them.
TEST_F(Kill, ASignalLeavesThePicturesOfItsFrames) {
  const fs::path calm = root_ / "undisturbed";
  ASSERT_EQ(BakeProcess(calm, {}).wait().code, 0);
  const auto expected = pictures(calm);
  int interrupted = 0;
  for (const int signal : {SIGTERM, SIGINT}) {
    const fs::path out = root_ / ("drawn" + std::to_string(signal));
    for (std::size_t frames = 2; frames < 12; frames += 4) {
      BakeProcess bake(out, {"--resume"});
      await_frame(out, bake, frames);
      if (!interrupt(signal, out, bake)) break;
      ++interrupted;
      const auto found = pictures(out);
      for (const int frame : kept_frames(out)) {
        char number[16];
        std::snprintf(number, sizeof number, ".%04d.png", frame);
        for (const auto& [name, bytes] : expected) {
          if (!name.ends_with(number)) continue;
          ASSERT_TRUE(found.contains(name)) << name;
          EXPECT_TRUE(found.at(name) == bytes) << name;
        }
      }
    }
    const auto ended = BakeProcess(out, {"--resume"}).wait();
    EXPECT_EQ(ended.code, 0) << ended.errors;
    expect_whole(out);
    EXPECT_TRUE(pictures(out) == expected);
  }
  EXPECT_GT(interrupted, 0);
}

TEST_F(Kill, SignalsFinishTheFrameAndSayTryAgain) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const fs::path out = root_ / ("signal" + std::to_string(signal));
    std::vector<int> kept;
    int interrupted = 0;
    for (int i = 0; i < kills_wanted / 5; ++i) {
      BakeProcess bake(out, {"--resume", "--no-render"});
      await_frame(out, bake, kept.size());
      sleep_for(random(0.0, 0.02));
      if (!interrupt(signal, out, bake)) break;
      ++interrupted;
      const std::vector<int> now = kept_frames(out);
      EXPECT_GT(now.size(), kept.size());
      EXPECT_TRUE(begins_with(now, kept));
      kept = now;
    }
    EXPECT_GT(interrupted, 0);
    resume(out);
  }
}

TEST_F(Kill, TheSecondBakeInAFolderIsSentAway) {
  const fs::path out = root_ / "shared";
  BakeProcess first(out);
  await_frame(out, first, 0);
  first.send(SIGSTOP);
  for (const char* way : {"--resume", "--no-render"}) {
    const auto second = BakeProcess(out, {way, "--no-render"}).wait();
    EXPECT_EQ(second.code, 75);
    EXPECT_NE(second.errors.find("another bake is writing here"), std::string::npos)
        << second.errors;
    EXPECT_EQ(std::count(second.errors.begin(), second.errors.end(), '\n'), 1) << second.errors;
  }
  first.send(SIGCONT);
  EXPECT_EQ(first.wait().code, 0);
  expect_whole(out);
}

}  // namespace
}  // namespace thew::tests

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) thew::tests::kills_wanted = std::atoi(argv[1]);
  if (argc > 2) thew::tests::seed = static_cast<unsigned>(std::atoi(argv[2]));
  return RUN_ALL_TESTS();
}
