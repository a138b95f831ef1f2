// SPDX-License-Identifier: Apache-2.0
// A show that is run on this machine, thew farm --local: interrupted and gone on with, one bake of
// it failing; at the end all is what single bakes make.
#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

constexpr int kRetry = 75, kOutput = 4;

class FarmHere : public testing::Test {
 protected:
  FarmHere() {
    fs::remove_all(root_);
    fs::create_directories(root_);
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/pair", root_ / "pair", fs::copy_options::recursive);
    std::ofstream(root_ / "jobs.toml") << R"(
chunk = 3
pictures = 4
exports = ["baked.obj"]
[[character]]
name = "moving"
scene = "pair/scene.toml"
[[character]]
name = "posed"
scene = "pair/scene.toml"
set = ["solver.integrator=quasi_static"]
[[shot]]
name = "slow"
characters = ["moving"]
set = ["solver.substeps=800"]
frames = "1-11x5"
[[shot]]
name = "calm"
frames = "1-5"
)";
  }
  ~FarmHere() override { fs::remove_all(root_); }

  std::vector<std::string> words(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"farm", root_ / "jobs.toml", "--threads", "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  CommandProcess::Ended run(const std::vector<std::string>& more) const {
    return CommandProcess(words(more)).wait();
  }
  // The last line that it prints says how many tasks there were; `ran` counts those that ended.
  static int ran(const std::string& errors) {
    int count = 0;
    for (size_t at = 0; (at = errors.find(" of ", at)) != std::string::npos; ++at) {
      count += errors.find(": ", at) < errors.find('\n', at);
    }
    return count;
  }
  void expect_as_alone(const std::string& name, const std::vector<std::string>& more) const {
    const fs::path alone = root_ / "alone" / name, farmed = root_ / "bakes" / name;
    std::vector<std::string> words = {
        "bake", root_ / "pair/scene.toml", "--threads", "1", "--out", alone, "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    ASSERT_EQ(CommandProcess(words).wait().code, 0);
    EXPECT_TRUE(bytes_of(alone / "bake.h5") == bytes_of(farmed / "bake.h5")) << name;
    int pictures = 0;
    for (const auto& entry : fs::directory_iterator(alone / "frames")) {
      if (entry.path().extension() != ".png") continue;
      ++pictures;
      EXPECT_TRUE(bytes_of(entry.path()) == bytes_of(farmed / "frames" / entry.path().filename()))
          << name << entry.path();
    }
    EXPECT_GT(pictures, 1);
    EXPECT_TRUE(fs::exists(farmed / "baked.0001.obj"));
    EXPECT_TRUE(temporary_files(farmed).empty());
  }

  const fs::path root_ = fs::path(testing::TempDir()) / ("thew_farm_" + std::to_string(getpid()));
};

TEST_F(FarmHere, GoesOnAndIsWhatSingleBakesAre) {
  EXPECT_EQ(run({"--local", "--dry-run"}).code, 0);
  EXPECT_FALSE(fs::exists(root_ / "bakes"));
  EXPECT_EQ(run({"--local", "--submit"}).code, 2);
  EXPECT_EQ(run({}).code, 2);

  const fs::path foreign = root_ / "bakes/calm/posed/bake.h5";
  fs::create_directories(foreign.parent_path());
  std::ofstream(foreign) << "of somebody else";
  CommandProcess first(words({"--local"}));
  const fs::path manifest = root_ / "bakes/slow/moving/bake.parts/manifest.jsonl";
  while (!first.ended() && bytes_of(manifest).empty()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  first.send(SIGTERM);
  const auto interrupted = first.wait();
  EXPECT_EQ(interrupted.code, kRetry) << interrupted.errors;
  const std::vector<int> kept = kept_frames(root_ / "bakes/slow/moving");
  EXPECT_FALSE(kept.empty());
  EXPECT_LT(kept.size(), 3u);

  const auto failed = run({"--local"});
  EXPECT_EQ(failed.code, kOutput) << failed.errors;
  EXPECT_NE(failed.errors.find("calm.posed.join.1 ended with 4"), std::string::npos);
  // 2 of pictures, finish, export
  EXPECT_NE(failed.errors.find(" and 4 waited for them"), std::string::npos) << failed.errors;
  EXPECT_EQ(bytes_of(foreign), "of somebody else");
  EXPECT_FALSE(fs::exists(root_ / "bakes/calm/posed/frames"));

  fs::remove(foreign);
  const auto mended = run({"--local"});
  const bool has_report =
      CommandProcess({"report"}).wait().errors.find("no command") == std::string::npos;
  EXPECT_EQ(mended.code, has_report ? 0 : 2) << mended.errors;
  EXPECT_EQ(ran(mended.errors), 7 + 1) << mended.errors;  // 2 chunks and join before these
  EXPECT_EQ(ran(run({"--local"}).errors), 1);             // the report alone
  expect_as_alone("slow/moving", {"--set", "solver.substeps=800", "--frames", "1-11x5"});
  expect_as_alone("calm/moving", {"--frames", "1-5"});
  expect_as_alone("calm/posed", {"--set", "solver.integrator=quasi_static", "--frames", "1-5"});
}

}  // namespace
}  // namespace thew::tests
