// SPDX-License-Identifier: Apache-2.0
//
// Frames of quasi_static on a character with its own skin: its arm bent by hinges, and moved by an
// animation from the bind pose, with arms sideways, to the breast.
#include <algorithm>
#include <cstdio>

#include "sim/bake/measure.h"
#include "sim/lone_frame.h"
#include "sim/solver/drive.h"
#include "tests/property/every.h"
#include "tests/unit/tools/fit/new.h"

namespace thew::tests {
namespace {

class LoneFigure : public NewScene {
 protected:
  Model made(std::vector<std::string> settings = {}) {
    EXPECT_EQ(new_command(asked(kFigure, "right")), ExitCode::kDone);
    settings.push_back("solver.integrator=quasi_static");
    return build_model(read_scene(folder / "character.toml", settings));
  }
  void solve(const Model& model, double frame, State& state) {
    solve_lone_frame(model, (frame - 1.0) / model.fps, parallel_, state, seconds_);
  }
  static Points by_weights(const Model& model, const State& state) {
    Points x;
    skin_vertices(model.skinned->weights, model.skinned->mesh, state.bodies, x);
    return x;
  }
  // Each of these frames against one that is a sixteenth later.
  void expect_continuous(const Model& model, const std::vector<double>& frames) {
    for (const double frame : frames) {
      State before, after;
      solve(model, frame, before);
      solve(model, frame + 1.0 / 16.0, after);
      double bones = 0.0, muscles = 0.0;
      for (size_t b = 0; b < model.bones.size(); ++b) {
        bones = std::max(bones, largest_distance(before.bones[b].x, after.bones[b].x));
      }
      for (size_t m = 0; m < model.muscles.size(); ++m) {
        muscles = std::max(muscles, largest_distance(before.muscles[m].x, after.muscles[m].x));
        EXPECT_LT(after.muscles[m].volume_error, 1e-12);
        EXPECT_LE(after.muscles[m].ladder.frame_rung, Rung::kSubsteps) << model.muscles[m].name;
      }
      const double skin = largest_distance(before.skin.x, after.skin.x);
      // Fingertips reach beyond the hand's bones.
      const double carried = largest_distance(by_weights(model, before), by_weights(model, after));
      std::printf("frame %g: bones %.2f, muscles %.2f, skin %.2f mm, by weights alone %.2f\n",
                  frame, 1e3 * bones, 1e3 * muscles, 1e3 * skin, 1e3 * carried);
      EXPECT_GT(bones, 0.0);
      EXPECT_LT(muscles, 1.5 * bones + 5e-4) << frame;
      EXPECT_LT(skin, 1.5 * carried + 6e-4) << frame;
    }
  }

  Parallel parallel_{1};
  StageSeconds seconds_;
};

TEST_F(LoneFigure, BendsInProportionToItsBones) {
  const Model model = made();
  ASSERT_TRUE(stands_alone(model));
  expect_continuous(model, every(2) == 1 ? std::vector<double>{4, 10, 15, 20, 25, 30, 33, 35}
                                         : std::vector<double>{4, 20, 35});
}

// In an elbow bent as far as it goes a muscle is pinched. What it is said to swing by is what it
// does: where less is allowed a rung has to stand in, and where more is, none.
TEST_F(LoneFigure, SaysByHowMuchAPinchedMuscleSwings) {
  Model model =
      made({"rig.clip={ unit = \"deg\", keys = { elbow_right = [[1, 12], [37, 140]] } }"});
  int muscle = -1;  // the one that swings most in the fold
  const auto measured = [&](double frame) {
    State state = initial_state(model);
    Measuring measuring = start_measuring(model, state);
    solve(model, frame, state);
    const std::vector<MuscleMeasures> of = measure(model, measuring, parallel_, state).muscles;
    if (muscle < 0) {
      const auto less = [](const auto& a, const auto& b) { return a.swing < b.swing; };
      muscle = static_cast<int>(std::max_element(of.begin(), of.end(), less) - of.begin());
    }
    return of[muscle];
  };
  const MuscleMeasures bent = measured(37);
  std::printf("%s swings by %.3f mm\n", model.muscles[muscle].name.c_str(), 1e3 * bent.swing);
  EXPECT_EQ(measured(2).swing, 0.0);  // all but straight, where nothing is pinched
  EXPECT_GT(bent.swing, 1e-5);
  EXPECT_LE(bent.swing, model.lengths.pinched_swing);
  EXPECT_EQ(bent.rung, Rung::kNone);
  model.lengths.pinched_swing = 0.5 * bent.swing;
  const MuscleMeasures refused = measured(37);
  EXPECT_GT(refused.rung, Rung::kSubsteps);
  EXPECT_LE(refused.swing, model.lengths.pinched_swing);
}

// From the hanging arm to one that is raised forwards by a right angle, the elbow bent by another.
// In the bind pose, where the way to each frame begins, the arm points sideways.
TEST_F(LoneFigure, IsAnimatedInProportionToItsBones) {
  Model model = made();
  const SceneHinge elbow = read_scene(folder / "character.toml").character.hinges.at(0);
  BodyClip& clip = model.character->clip;
  clip.duration = 1.0;
  clip.tracks.resize(2);
  BodyTrack &upper = clip.tracks[0], &fore = clip.tracks[1];
  upper.body = find_body(model.skeleton, "RightArm");
  fore.body = find_body(model.skeleton, elbow.body);
  const Vec3 bound = model.skeleton.joint_in_parent[fore.body].translation().normalized();
  const Mat3 hanging = least_turn(bound, -Vec3::UnitY());
  upper.rotation.times = fore.rotation.times = {0.0, 1.0};
  for (const double bent : {0.0, 90.0 * kDegree}) {
    upper.rotation.values.emplace_back(Mat3(rotation_about(-Vec3::UnitX(), bent) * hanging));
    fore.rotation.values.emplace_back(rotation_about(elbow.axis, bent - elbow.at_bind));
  }
  model.last_frame = 25;
  expect_continuous(model, every(2) == 1 ? std::vector<double>{1, 5, 9, 13, 17, 21, 24}
                                         : std::vector<double>{1, 12, 24});
}

}  // namespace
}  // namespace thew::tests
