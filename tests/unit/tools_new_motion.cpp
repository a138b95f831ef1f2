// SPDX-License-Identifier: Apache-2.0
//
// What thew new makes of a character, moved.
#include <algorithm>

#include "sim/drive.h"
#include "sim/measure.h"
#include "tools_new.h"

namespace thew {
namespace {

// An upper arm a quarter as thick as a person's on a forearm twice as long: in the fold the tendons
// ran straight from one to the other, 22 mm outside of the skin.
TEST_F(NewScene, TheRobotsMusclesStayAtItsElbow) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  MadeArm arm(asked(data("robot.glb"), "left", 0.4));
  const std::vector<double> areas = rest_belly_areas(arm.model, initial_state(arm.model));
  double most = 0.0;
  for (int frame = 1; frame <= 35; ++frame) {
    arm.step(frame);
    most = std::max(most, measure(arm.model, areas, arm.parallel, arm.state).skin.max_poke_through);
  }
  std::printf("%.1f mm outside\n", 1e3 * most);
  EXPECT_LT(most, 6e-3);
}

// m, by which a node's step differs from its last, at most, where the elbow bends from 90 to 120
// degrees by a third of a degree a step.
double largest_change_of_step(const NewOptions& options) {
  MadeArm arm(options, {"rig.clip={ unit = \"deg\", keys = { elbow_" + options.side +
                            " = [[1, 90], [91, 120]] } }",
                        "skin.enabled=false"});
  const size_t count = arm.model.muscles.size();
  std::vector<Rows> before(count), step(count);
  double most = 0.0;
  for (int frame = 1; frame <= 90; ++frame) {
    arm.step(frame);
    for (size_t m = 0; m < count; ++m) {
      Rows now = arm.state.muscles[m].x;
      for (size_t i = 0; frame > 1 && i < now.size(); ++i) now[i] -= before[m][i];
      if (frame > 2) most = std::max(most, largest_distance(now, step[m]));
      before[m] = arm.state.muscles[m].x;
      step[m].swap(now);
    }
  }
  std::printf("%.2f mm\n", 1e3 * most);
  return most;
}

// The figure's forearm was bent forward below the elbow, into the end of its brachialis; what
// contact made of that changed by 12 mm from step to step. The man's triceps was carried through
// the back of his humerus: 6 mm.
TEST_F(NewScene, MusclesBendTheElbowInSmallSteps) {
  for (const auto& [file, scale] : characters()) {
    for (const char* side : {"right", "left"}) {
      EXPECT_LT(largest_change_of_step(asked(file, side, scale)), 2e-3) << file << side;
    }
  }
}

// Its own animations hold its forearms rolled by 89 and 69 degrees against the bind pose, and its
// upper arms are a quarter of a person's: muscles made in the bind pose with a person's contact
// distances were wrung through the bones and drawn out until the solver gave up.
TEST_F(NewScene, TheRobotsOwnAnimationsBake) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  const NewOptions options = asked(data("robot.glb"), "both", 0.4);
  testing::internal::CaptureStderr();
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const std::string warned = testing::internal::GetCapturedStderr();
  EXPECT_HAS(warned, "animation \"Robot_Wave\" rolls the right forearm");
  EXPECT_EQ(warned.find("Robot_Walking"), std::string::npos);
  // The last rolls a forearm by 104 degrees: with the ulna rolled it ended in frame 16.
  for (const auto& [name, frames] : {std::pair("Robot_Idle", 10),
                                     {"Robot_Walking", 10},
                                     {"Robot_Sitting", 10},
                                     {"Robot_Wave", 20}}) {
    const Model model = build_model(read_scene(
        options.out,
        {"rig.clip={ animation = \"" + std::string(name) + "\" }", "skin.enabled=false"}));
    Parallel parallel(1);
    State state = initial_state(model);
    StageSeconds seconds;
    settle(model, parallel, state);
    for (int frame = 1; frame <= frames; ++frame) {
      step_frame(model, frame / 24.0, parallel, state, seconds);
      for (const MuscleState& muscle : state.muscles) EXPECT_LE(muscle.volume_error, 1e-12) << name;
    }
  }
}

// The same figure with its elbow bent by 120 degrees, where its weights draw the skin in.
TEST_F(NewScene, MusclesStayUnderTheSkinOfABentElbow) {
  MadeArm arm(asked(kFigure, "right"));
  const Model& model = arm.model;
  State& state = arm.state;
  for (int frame = 1; frame < 36; ++frame) {
    arm.step(frame);
  }
  const std::vector<double> areas = rest_belly_areas(model, initial_state(model));
  const auto farthest = [&] {
    TriMesh skin = model.character->character.mesh;
    for (size_t i = 0; i < skin.vertices.size(); ++i) skin.vertices[i] = to_vec(state.skin.x[i]);
    double most = 0.0;
    for (const MuscleState& muscle : state.muscles) {
      for (const Row& x : muscle.x) {
        if (winding(skin, to_vec(x)) < 0.5) most = std::max(most, distance(skin, to_vec(x)));
      }
    }
    return most;
  };
  const auto measured = [&] {
    return measure(model, areas, arm.parallel, state).skin.max_poke_through;
  };
  std::printf("%.2f mm outside\n", 1e3 * farthest());
  EXPECT_LT(farthest(), 2e-3);
  EXPECT_NEAR(measured(), farthest(), 1e-3);
  // As the weights alone have it.
  skin_vertices(model.skinned->weights, model.skinned->mesh, state.bodies, state.skin.x);
  std::printf("%.2f mm outside by its weights alone, %.2f measured\n", 1e3 * farthest(),
              1e3 * measured());
  EXPECT_GT(farthest(), 0.01);
  EXPECT_NEAR(measured(), farthest(), 1e-3);
}

// The displacement on top of the character's own weights goes with pose and muscles, and does not
// leap: between two frames, of which the muscles are interpolated, it goes in steps as small as
// theirs, also in the fold beyond 90 degrees.
TEST_F(NewScene, SkinMovesContinuouslyIntoTheFold) {
  MadeArm arm(asked(kFigure, "right"));
  auto& [model, parallel, state, seconds] = arm;
  for (int frame = 1; frame <= 26; ++frame) arm.step(frame);
  constexpr int kFine = 64;
  Rows carried, before, before_fine;
  double coarse = 0.0, fine = 0.0;  // m, most in 1/8 and in 1/64 of a frame
  for (int frame = 27; frame <= 35; ++frame) {
    State between = state;
    arm.step(frame);
    const std::vector<MuscleState> from = between.muscles;
    for (int k = 1; k <= kFine; ++k) {
      const double share = 1.0 * k / kFine;
      drive_bones(model, (frame - 1 + share) / 24.0, between);
      for (size_t m = 0; m < from.size(); ++m) {
        Rows& x = between.muscles[m].x;
        for (size_t i = 0; i < x.size(); ++i) {
          x[i] = (1.0 - share) * from[m].x[i] + share * state.muscles[m].x[i];
        }
      }
      step_skinned(*model.skinned, between.bodies, muscles_of(model, between), between.skin);
      skin_vertices(model.skinned->weights, model.skinned->mesh, between.bodies, carried);
      Rows now = between.skin.x;
      for (size_t i = 0; i < now.size(); ++i) now[i] -= carried[i];
      if (!before_fine.empty()) fine = std::max(fine, largest_distance(now, before_fine));
      if (k % 8 == 0) {
        if (!before.empty()) coarse = std::max(coarse, largest_distance(now, before));
        before = now;
      }
      before_fine.swap(now);
    }
  }
  std::printf("%.3f mm in 1/8 of a frame, %.3f mm in 1/64\n", 1e3 * coarse, 1e3 * fine);
  EXPECT_LT(fine, coarse / 4.0);
  EXPECT_LT(coarse, 0.0025);
}

}  // namespace
}  // namespace thew
