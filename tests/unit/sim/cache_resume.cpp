// SPDX-License-Identifier: Apache-2.0
// What a bake that was cut short leaves, and what the next one makes of it.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>

#include "tests/unit/sim/cache_bake.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

std::vector<int> completed(const fs::path& folder, const BakeInfo& info) {
  return BakeWriter(folder, info, true).completed();
}

class ResumeTest : public CacheTest {
 protected:
  ResumeTest() {
    bake_small(folder_, info_, false, 3);
    fs::copy(parts_, folder_ / "kept");
  }
  /// The parts as they were at first.
  void restore() {
    fs::remove_all(parts_);
    fs::copy(folder_ / "kept", parts_);
  }

  const BakeInfo info_ = small_info(true);
  const fs::path parts_ = folder_ / "bake.parts";
};

TEST_F(ResumeTest, GivesBackEachFrameWithItsState) {
  const BakeWriter writer(folder_, info_, true);
  EXPECT_EQ(writer.completed(), (std::vector<int>{-2, 0, 2}));
  for (const int number : writer.completed()) {
    const BakeFrame read = writer.read_completed(number), written = small_frame(info_, number);
    EXPECT_EQ(read.frame, number);
    EXPECT_EQ(read.positions, written.positions);
    EXPECT_EQ(read.metrics, written.metrics);
    EXPECT_EQ(read.state, written.state);
  }
  expect_error(ErrorCode::kUsage, "frame 4", [&] { writer.read_completed(4); });
}

TEST_F(ResumeTest, EndsInTheSameBytes) {
  const std::string hash = bake_small(folder_ / "whole", info_);
  EXPECT_EQ(bake_small(folder_, info_, true), hash);
  EXPECT_EQ(bytes_of(folder_ / "bake.h5"), bytes_of(folder_ / "whole/bake.h5"));
}

TEST_F(ResumeTest, BeginsAgainUnlessAskedTo) {
  EXPECT_TRUE(BakeWriter(folder_, info_, false).completed().empty());
  EXPECT_TRUE(completed(folder_, info_).empty());  // they are gone now
}

TEST_F(ResumeTest, ManifestIsOneLineAPart) {
  const std::string text = bytes_of(parts_ / "manifest.jsonl");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  const auto size = fs::file_size(parts_ / "frame.0002.part");
  const std::string line =
      "{\"frame\":2,\"file\":\"frame.0002.part\",\"bytes\":" + std::to_string(size) +
      ",\"hash\":\"";
  EXPECT_NE(text.find("\n" + line), std::string::npos) << text;
}

TEST_F(ResumeTest, FindsEveryBitThatChanged) {
  const fs::path part = parts_ / "frame.0000.part";
  const std::string good = bytes_of(part);
  for (std::size_t byte = 0; byte < good.size(); byte += 41) {
    restore();
    std::string bad = good;
    bad[byte] = static_cast<char>(bad[byte] ^ (1 << byte % 8));
    put_bytes(part, bad);
    EXPECT_EQ(completed(folder_, info_), std::vector<int>{-2}) << byte;
    EXPECT_FALSE(fs::exists(part));
    EXPECT_FALSE(fs::exists(parts_ / "frame.0002.part"));  // came after it
  }
}

TEST_F(ResumeTest, FindsAPartThatIsShortLongOrMissing) {
  const fs::path part = parts_ / "frame.0002.part";
  const std::string good = bytes_of(part);
  for (const std::string& bad :
       {good.substr(0, good.size() - 1), good.substr(0, 8), std::string(), good + "x"}) {
    restore();
    put_bytes(part, bad);
    EXPECT_EQ(completed(folder_, info_), (std::vector<int>{-2, 0})) << bad.size();
  }
  restore();
  fs::remove(part);
  EXPECT_EQ(completed(folder_, info_), (std::vector<int>{-2, 0}));
}

TEST_F(ResumeTest, TakesAManifestUpToItsTornLine) {
  const std::string good = bytes_of(parts_ / "manifest.jsonl");
  const std::size_t first = good.find('\n') + 1, second = good.find('\n', first) + 1;
  for (std::size_t cut = 0; cut <= good.size(); cut += 13) {
    restore();
    put_bytes(parts_ / "manifest.jsonl", good.substr(0, cut));
    // A line counts once all but its end is there.
    const std::size_t whole = (cut + 1 >= first) + (cut + 1 >= second) + (cut + 1 >= good.size());
    EXPECT_EQ(completed(folder_, info_).size(), whole) << cut;
  }
}

TEST_F(ResumeTest, DoesNotFollowAManifestOutOfItsFolder) {
  fs::copy_file(parts_ / "frame.-002.part", folder_ / "elsewhere");
  std::string text = bytes_of(parts_ / "manifest.jsonl");
  text.replace(text.find("frame.-002.part"), 15, "../elsewhere");
  put_bytes(parts_ / "manifest.jsonl", text);
  EXPECT_TRUE(completed(folder_, info_).empty());
  EXPECT_TRUE(fs::exists(folder_ / "elsewhere"));
}

// Found by the fuzzer: a number that no integer holds.
TEST_F(ResumeTest, RefusesAManifestWhoseNumbersAreNone) {
  const std::string good = bytes_of(parts_ / "manifest.jsonl");
  const std::size_t at = good.find("\"bytes\":") + 8, end = good.find(',', at);
  for (const char* number : {"2555555555555555555555555555555555555555555555555589", "-1", "1.5",
                             "18446744073709551615", "1e300", "\"7\"", "null"}) {
    put_bytes(parts_ / "manifest.jsonl", std::string(good).replace(at, end - at, number));
    EXPECT_TRUE(completed(folder_, info_).empty()) << number;
    restore();
  }
}

TEST_F(ResumeTest, SaysInWhatTheSceneDiffers) {
  BakeInfo other = info_;
  other.fps = 30.0;
  expect_error(ErrorCode::kUsage, "fps was 24.0 and is 30.0", [&] { completed(folder_, other); });
  other = info_;
  other.scene_hash = "fedcba";
  expect_error(ErrorCode::kUsage, "scene_hash was \"0123", [&] { completed(folder_, other); });
  other = info_;
  other.meshes[1].name = "triceps";
  expect_error(ErrorCode::kUsage, "mesh \"triceps\" is new, mesh \"biceps\" is gone",
               [&] { completed(folder_, other); });
  other = info_;
  other.meshes[1].weights[1] += 1e-15;
  expect_error(ErrorCode::kUsage, "mesh \"biceps\" has changed",
               [&] { completed(folder_, other); });
  other = info_;
  other.scene_hash = "fedcba";
  other.scene_text = "[solver]\niterations = 4\n";
  expect_error(ErrorCode::kUsage,
               "line 2 of the scene was \"iterations = 3\" and is \"iterations = 4\"",
               [&] { completed(folder_, other); });
  other.scene_hash = info_.scene_hash;  // the text alone, of a camera for instance, is no matter
  EXPECT_EQ(completed(folder_, other).size(), 3u);
  EXPECT_EQ(completed(folder_, info_).size(), 3u);  // nothing was lost by asking
}

TEST_F(ResumeTest, OtherFramesKeepWhatTheyShare) {
  BakeInfo longer = info_;
  longer.frames = {-2, 0, 2, 4, 6};
  EXPECT_EQ(completed(folder_, longer), (std::vector<int>{-2, 0, 2}));
  BakeInfo other = info_;
  other.frames = {-2, 0, 1};
  EXPECT_EQ(completed(folder_, other), (std::vector<int>{-2, 0}));
}

TEST_F(ResumeTest, APartThatChangesLaterIsNotPacked) {
  BakeWriter writer(folder_, info_, true);
  const fs::path part = parts_ / "frame.0000.part";
  put_bytes(part, bytes_of(part).replace(100, 1, "x"));
  expect_error(ErrorCode::kOutput, "frame.0000.part", [&] { writer.pack(); });
  EXPECT_FALSE(fs::exists(folder_ / "bake.h5"));
}

TEST_F(ResumeTest, ASecondBakeIsSentAway) {
  const BakeWriter first(folder_, info_, true);
  expect_error(ErrorCode::kRetry, "another bake", [&] { BakeWriter(folder_, info_, false); });
  EXPECT_EQ(first.read_completed(2).positions, small_frame(info_, 2).positions);
}

TEST_F(ResumeTest, AChildThatOutlivesABakeDoesNotKeepItsLock) {
  std::optional<BakeWriter> first(std::in_place, folder_, info_, true);
  const pid_t child = fork();
  if (child == 0) {
    for (;;) pause();
  }
  first.reset();
  EXPECT_NO_THROW(BakeWriter(folder_, info_, true));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST_F(ResumeTest, CompletedFramesSurviveAKill) {
  const std::string hash = bake_small(folder_ / "whole", info_);
  for (std::size_t kept = 0; kept < 4; ++kept) {
    const fs::path folder = folder_ / std::to_string(kept);
    int done[2];
    ASSERT_EQ(pipe(done), 0);
    const pid_t child = fork();
    if (child == 0) {  // tells of each frame, then goes on until it is killed
      BakeWriter writer(folder, info_, false);
      for (const int frame : info_.frames) {
        writer.write(small_frame(info_, frame));
        if (write(done[1], "", 1) != 1) _exit(1);
      }
      for (;;) pause();
    }
    char byte = 0;
    for (std::size_t i = 0; i < kept; ++i) ASSERT_EQ(read(done[0], &byte, 1), 1);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(done[0]);
    close(done[1]);
    EXPECT_GE(completed(folder, info_).size(), kept);  // and the lock went with it
    EXPECT_EQ(bake_small(folder, info_, true), hash);
    EXPECT_EQ(bytes_of(folder / "bake.h5"), bytes_of(folder_ / "whole/bake.h5"));
  }
}

}  // namespace
}  // namespace thew::tests
