// SPDX-License-Identifier: Apache-2.0
// SIGTERM and SIGINT to every command that may take long: it ends with 75, one line, and leaves no
// temporary file. The signal is there before the command is, so that no timing decides.
#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

class Interrupted : public BakeTest {
 protected:
  // With the signal pending, in a temporary folder of its own.
  static CommandProcess::Ended run(const std::vector<std::string>& words, int signal,
                                   const fs::path& folder) {
    const fs::path temporary = folder / "temporary";
    fs::create_directories(temporary);
    const auto ended = CommandProcess(words, [&] {
                         setenv("TMPDIR", temporary.c_str(), 1);
                         sigset_t set;
                         sigemptyset(&set);
                         sigaddset(&set, signal);
                         sigprocmask(SIG_BLOCK, &set, nullptr);
                         raise(signal);
                       }).wait();
    EXPECT_TRUE(fs::is_empty(temporary));
    EXPECT_TRUE(temporary_files(folder).empty());
    return ended;
  }
  static void expect_interrupted(std::vector<std::string> words) {
    for (const int signal : {SIGTERM, SIGINT}) {
      const fs::path folder = root_ / ("out" + std::to_string(signal));
      fs::remove_all(folder);
      fs::create_directories(folder);
      std::vector<std::string> with_folder = words;
      for (std::string& word : with_folder) {
        if (word.starts_with("OUT/")) word = folder / word.substr(4);
      }
      SCOPED_TRACE(words[0] + " " + words.back());
      const auto ended = run(with_folder, signal, folder);
      EXPECT_EQ(ended.code, 75) << ended.errors;
      EXPECT_TRUE(ended.errors.starts_with("thew: interrupted; ")) << ended.errors;
      EXPECT_EQ(std::count(ended.errors.begin(), ended.errors.end(), '\n'), 1) << ended.errors;
    }
  }
  const std::string scene_ = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  const std::string bake_ = root_ / "whole/bake.h5";
};

TEST_F(Interrupted, Bake) {
  expect_interrupted({"bake", scene_, "--progress", "none", "--out", "OUT/bake"});
  // While it settles, and among frames that are not written.
  expect_interrupted({"bake", scene_, "--progress", "none", "--set", "scene.settle=1000",
                      "--frames", "16", "--out", "OUT/bake"});
  expect_interrupted({"bake", scene_, "--progress", "none", "--set", "scene.settle=0", "--frames",
                      "16", "--out", "OUT/bake"});
}

TEST_F(Interrupted, Render) {
  expect_interrupted({"render", bake_, "--progress", "none", "--out", "OUT/pictures"});
  expect_interrupted({"render", bake_, "--progress", "none", "--frames", "1", "--turntable", "4",
                      "--out", "OUT/pictures"});
}

TEST_F(Interrupted, Export) {
  for (const char* file :
       {"bake.obj", "bake.ply", "bake.glb", "bake.usda", "bake.usdc", "bake.usdz", "bake.abc",
        "bake.pc2", "bake.mdd"}) {
    expect_interrupted(
        {"export", bake_, "--progress", "none", "--mesh", "front", std::string("OUT/") + file});
  }
}

TEST_F(Interrupted, Compare) {
  expect_interrupted({"compare", bake_, bake_});
  fs::copy(bake_, root_ / "other.h5", fs::copy_options::overwrite_existing);
  expect_interrupted({"compare", bake_, root_ / "other.h5", "--html", "OUT/page.html"});
}

TEST_F(Interrupted, Inspect) { expect_interrupted({"inspect", bake_}); }

TEST_F(Interrupted, Report) {
  expect_interrupted({"report", root_ / "whole", "--html", "OUT/page.html"});
}

TEST_F(Interrupted, Golden) {
  expect_interrupted({"golden", "update", scene_, "--progress", "none", "--golden", "OUT/golden"});
  fs::copy(THEW_SOURCE_DIR "/tests/golden/one_muscle", root_ / "golden",
           fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  expect_interrupted({"golden", "check", THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml",
                      "--progress", "none", "--golden", root_ / "golden"});
}

TEST_F(Interrupted, Chart) {
  expect_interrupted({"chart", scene_, "--progress", "none", "--out", "OUT/chart"});
}

TEST_F(Interrupted, Paper) {
  expect_interrupted({"paper", "--quick", "--progress", "none", "--out", "OUT/paper"});
}

TEST_F(Interrupted, New) {
  const fs::path robot = THEW_SHARED_DATA "/robot.glb";
  if (!fs::exists(robot)) GTEST_SKIP() << "robot.glb is not there";
  expect_interrupted({"new", robot, "--scale", "0.4", "--out", "OUT/robot.toml"});
}

}  // namespace
}  // namespace thew::tests
