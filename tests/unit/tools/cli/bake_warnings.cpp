// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/bake_warnings.h"

#include <gtest/gtest.h>

#include "rig/text.h"
#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class BakeWarnings : public TempFolder {
 protected:
  // What is said of the made-up figure with two muscles in its upper arm, of radii in m.
  std::string said(const std::string& one, const std::string& two) {
    fs::copy_file(fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf",
                  folder / "figure.gltf", fs::copy_options::overwrite_existing);
    const auto muscle = [](const std::string& name, const std::string& radius) {
      return "[[muscle]]\nname = \"" + name +
             "\"\npath = [[\"LeftArm\", 0.05, -0.04, 0], [\"LeftArm\", 0.15, -0.13, 0]]\n"
             "profile = { around = 12, rings = 9, radius = [[0, " +
             radius + "]] }\n";
    };
    CommandOptions options;
    options.input = write("figure.toml",
                          "[scene]\nframes = \"3-4\"\n[rig]\nfile = \"figure.gltf\"\n"
                          "[skin]\nkind = \"skinned\"\n[contact]\nenabled = false\n" +
                              muscle("one", one) + muscle("two", two));
    options.out = folder / "out";
    options.pictures = false;
    options.overwrite = true;
    options.progress = "none";
    testing::internal::CaptureStderr();
    const ExitCode code = bake_command(options);
    const std::string stderr_text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, ExitCode::kDone);
    const std::string report = read_whole(options.out / "report.json", 1 << 20);
    EXPECT_EQ(report.find("stands out") == std::string::npos,
              stderr_text.find("stands out") == std::string::npos);
    return stderr_text;
  }
};

TEST_F(BakeWarnings, ThatAMuscleStandsOutOfTheSkinNamesItSizeAndFrame) {
  EXPECT_EQ(said("0.01", "0.012").find("stands out"), std::string::npos);
  const std::string text = said("0.01", "0.08");
  std::printf("%s", text.c_str());
  EXPECT_HAS(text, "muscle \"two\" stands out of the character's skin by ");
  EXPECT_HAS(text, " mm in frame ");
  EXPECT_HAS(said("0.08", "0.01"), "muscle \"one\" stands out");
}

TEST(SkinWarning, ThatFleshLeavesNoRoomNamesSizeAndFrame) {
  Model model;
  model.has_skin = model.skin.settings.keeps_volume = true;
  BakeResult result;
  for (const double error : {0.0, 0.031, 1e-14}) {
    result.measures.emplace_back().skin.volume_error = error;
  }
  const auto said = [&] { return skin_too_full(model, {7, 8, 9}, result.measures); };
  EXPECT_EQ(said(),
            "skin: 0.031 of its volume off in frame 8, where what is below leaves no room; more "
            "fat over it at rest gives some");
  result.measures[1].skin.volume_error = 2e-14;
  EXPECT_EQ(said(), "");
}

TEST(SettleWarning, IsOfMusclesThatAreSeenToMove) {
  Model model;
  model.settle = 2.0;
  BakeResult result;
  result.settled = {2.0, 3e-4, 0, false};  // m/s
  EXPECT_EQ(not_at_rest(model, result), "");
  result.settled.speed = 0.02;
  EXPECT_HAS(not_at_rest(model, result), "after 2.00 s with nodes at 0.02 m/s");
  result.settled.converged = true;
  EXPECT_EQ(not_at_rest(model, result), "");
}

TEST(SwingWarning, NamesMuscleFramesAndMillimetres) {
  Model model;
  model.muscles.resize(2);
  model.muscles[0].name = "still";
  model.muscles[1].name = "brachialis";
  std::vector<FrameMeasures> measures(5);
  for (FrameMeasures& frame : measures) frame.muscles.resize(2);
  const std::vector<int> frames = {3, 4, 5, 6, 9};
  EXPECT_TRUE(swings_of(model, frames, measures).empty());
  measures[1].muscles[1].swing = 1e-4;
  measures[2].muscles[1].swing = 2.14e-4;
  measures[4].muscles[1].swing = 5e-5;
  const auto swings = swings_of(model, frames, measures);
  ASSERT_EQ(swings.size(), 1u);
  EXPECT_EQ(swings[0].frames, (std::vector<int>{4, 5, 9}));
  EXPECT_EQ(swings[0].swing_m, (std::vector<double>{1e-4, 2.14e-4, 5e-5}));
  EXPECT_EQ(
      swinging_muscles(swings),
      std::vector<std::string>{
          "muscle \"brachialis\" is pinched and finds no rest in frames 4-5, 9: its nodes "
          "swing by up to 0.21 mm (frame 5); more room between the bodies that pinch it gives "
          "it rest"});
}

TEST(RungWarning, SaysWhereFramesThatStandAloneMayPop) {
  Model model;
  model.muscles.resize(1);
  model.muscles[0].name = "brachialis";
  std::vector<FrameMeasures> measures(6);
  for (FrameMeasures& frame : measures) frame.muscles.resize(1);
  const std::vector<int> frames = {1, 2, 3, 4, 8, 9};
  const auto put = [&](std::vector<Rung> rungs) {
    for (size_t f = 0; f < rungs.size(); ++f) measures[f].muscles[0].rung = rungs[f];
    return rungs_that_pop(model, frames, measures);
  };
  using enum Rung;
  const std::vector<Rung> taken = {kNone, kCarried, kPairLetPass, kSubsteps, kCarried, kCarried};
  EXPECT_TRUE(put(taken).empty());  // blended
  model.solver.integrator = Integrator::kQuasiStatic;
  const auto lines = put(taken);  // 4 and 8 are not neighbours
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_HAS(lines[0], "muscle \"brachialis\"");
  EXPECT_HAS(lines[0], "may pop from frame 1 to 2, 3 to 4;");
  EXPECT_TRUE(put({kCarried, kCarried, kCarried, kCarried, kNone, kNone}).empty());
}

}  // namespace
}  // namespace thew::tests
