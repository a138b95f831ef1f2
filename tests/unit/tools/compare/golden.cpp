// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/cache_bake.h"
#include "tools/cli/commands.h"
#include "tools/compare/golden_files.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Golden : public TempFolder {
 protected:
  Golden() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/one_muscle", folder / "scene");
    options.input = folder / "scene/scene.toml";
    options.out = folder / "out";
    options.progress = "none";
    options.threads = 1;
    options.overrides = {kSmall};
    golden = folder / "scene/golden";
  }
  std::string update() {
    testing::internal::CaptureStdout();
    EXPECT_EQ(golden_update_command(options, golden), ExitCode::kDone);
    return testing::internal::GetCapturedStdout();
  }
  std::string check(ExitCode expected) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(golden_check_command(options, golden, {}), expected);
    return testing::internal::GetCapturedStdout();
  }

  static constexpr const char* kSmall = "render.size=[64, 36]";
  CommandOptions options;
  fs::path golden;
};

TEST_F(Golden, FirstOnesThenNothingThenWhatMoved) {
  EXPECT_HAS(input_error([&] { check(ExitCode::kDone); }), "thew golden update SCENE");
  testing::internal::GetCapturedStdout();
  options.frames = "1,12";
  EXPECT_HAS(update(), "first goldens");
  EXPECT_EQ(read_recipe(golden).frames, "1,12");
  options.frames = "";
  options.overrides = {};
  EXPECT_HAS(check(ExitCode::kDone),
             "the same within 0.0001 mm, 2 frames (largest distance 0 mm, both rounded to "
             "float32)\npictures: 4, all the same\n");
  EXPECT_FALSE(fs::exists(options.out / "compare.html"));

  const std::string bytes = bytes_of(golden / "bake.h5");
  write("scene/golden/README.md", "kept");
  EXPECT_HAS(update(), "nothing moved");
  EXPECT_EQ(read_recipe(golden).set, std::vector<std::string>{kSmall});
  EXPECT_EQ(bytes_of(golden / "bake.h5"), bytes);

  // On purpose: a change is tried, found, said, and kept.
  options.overrides = {kSmall, "muscle.flexor.weights=right"};
  EXPECT_HAS(check(ExitCode::kDifferent), "  flexor moved ");
  EXPECT_TRUE(fs::exists(options.out / "compare.html"));
  EXPECT_EQ(bytes_of(golden / "bake.h5"), bytes);
  const std::string moved = update();
  EXPECT_HAS(moved, "  flexor moved ");
  EXPECT_HAS(moved, "rewritten");
  EXPECT_NE(bytes_of(golden / "bake.h5"), bytes);
  options.overrides = {};
  EXPECT_HAS(check(ExitCode::kDone), "the same within");
  EXPECT_EQ(bytes_of(golden / "README.md"), "kept");

  // Fewer frames leave no picture behind.
  options.frames = "1";
  EXPECT_HAS(update(), "frame 12 is missing");
  EXPECT_FALSE(fs::exists(golden / "frames/muscles.0012.png"));
  EXPECT_TRUE(fs::exists(golden / "frames/muscles.0001.png"));
}

TEST_F(Golden, TheRendererIsKeptAndBrokenOnesAreMadeAnew) {
  options.frames = "1";
  update();
  EXPECT_TRUE(read_png(golden / "frames/muscles.0001.png").renderer.starts_with("softpipe, "));
  write("scene/golden/bake.h5", "broken");
  EXPECT_HAS(input_error([&] { check(ExitCode::kDone); }), "bake.h5");
  testing::internal::GetCapturedStdout();
  EXPECT_HAS(update(), "the old goldens cannot be compared");
  check(ExitCode::kDone);
  write("scene/golden/golden.json", "{\"frames\": 1}");
  EXPECT_HAS(input_error([&] { check(ExitCode::kDone); }), "golden.json");
  testing::internal::GetCapturedStdout();
}

}  // namespace
}  // namespace thew::tests
