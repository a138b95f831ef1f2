// SPDX-License-Identifier: Apache-2.0
//
// Frames of quasi_static stand by themselves: each is a function of its pose alone, a continuous
// one, and near to what a slow motion settles to. On the arm, with its skin and contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rig/math.h"
#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/property/every.h"

namespace thew::tests {
namespace {

Model arm(const std::vector<std::string>& overrides) {
  return build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", overrides));
}

const Model& lone_arm() {
  static const Model model = arm({"solver.integrator=quasi_static"});
  return model;
}

// At a frame of the clip, which need not be a whole one.
void solve(const Model& model, double frame, State& state, int threads = 1) {
  Parallel parallel(threads);
  StageSeconds unused;
  solve_lone_frame(model, (frame - model.first_frame) / model.fps, parallel, state, unused);
}

bool are_equal(const State& a, const State& b) {
  return pack_state(a) == pack_state(b);  // all that a step could go on from
}

struct Distances {
  double bones = 0.0, muscles = 0.0, skin = 0.0;  // m, the largest of a node
  double slip = 0.0;  // m, of the skin beside what the bodies carry it, in the bind pose
};
Distances between(const State& a, const State& b) {
  Distances out;
  for (size_t i = 0; i < a.bones.size(); ++i) {
    out.bones = std::max(out.bones, largest_distance(a.bones[i].x, b.bones[i].x));
  }
  for (size_t m = 0; m < a.muscles.size(); ++m) {
    out.muscles = std::max(out.muscles, largest_distance(a.muscles[m].x, b.muscles[m].x));
  }
  out.skin = largest_distance(a.skin.x, b.skin.x);
  out.slip = largest_distance(a.skin.slip, b.skin.slip);
  return out;
}

TEST(LoneArm, IsTheSameWhateverCameBefore) {
  const Model& model = lone_arm();
  ASSERT_TRUE(stands_alone(model));
  State state, straighter, bent;
  solve(model, 31, straighter);
  solve(model, 60, bent, 2);
  state = straighter;
  solve(model, 61, state);  // the pose of frame 60, at another time
  const Distances apart = between(state, bent);
  EXPECT_EQ(std::max({apart.bones, apart.muscles, apart.skin, apart.slip}), 0.0);
  solve(model, 60, state);
  EXPECT_TRUE(are_equal(state, bent));
  solve(model, 31, state);
  EXPECT_TRUE(are_equal(state, straighter));
}

// Frames at which the way to the pose takes a step more than just before.
std::vector<double> frames_of_one_more_step(const Model& model, int every) {
  std::vector<double> frames, joints;
  const double step = model.skin.settings.max_turn;
  int steps = 0;
  for (double frame = 1.0; frame <= 60.0; frame += 1.0 / 16.0) {
    joints_at(model, (frame - model.first_frame) / model.fps, joints);
    double turn = 0.0;
    for (const double joint : joints) turn = std::max(turn, std::abs(joint));
    const int now = static_cast<int>(std::ceil(turn / step - 0.05));
    if (now > steps && now % every == 0) frames.push_back(frame);
    steps = now;
  }
  return frames;
}

TEST(LoneArm, IsContinuousWhereTheWayGetsAStepLonger) {
  const Model& model = lone_arm();
  const std::vector<double> frames = frames_of_one_more_step(model, every(10));
  ASSERT_GE(frames.size(), 3u);
  for (const double frame : frames) {
    State before, after;
    solve(model, frame - 1.0 / 16.0, before);
    solve(model, frame, after);
    const Distances moved = between(before, after);
    std::printf("frame %.4f: bones %.2f, muscles %.2f, skin %.2f, by itself %.2f mm\n", frame,
                1e3 * moved.bones, 1e3 * moved.muscles, 1e3 * moved.skin, 1e3 * moved.slip);
    // Single nodes in the fold have no rest: 0.3 mm.
    EXPECT_LT(moved.muscles, moved.bones + 1e-4) << frame;
    EXPECT_LT(moved.skin, 1.1 * moved.bones + 5e-4) << frame;
    EXPECT_LT(moved.slip, 0.2 * moved.bones + 5e-4) << frame;
  }
}

// The dynamic arm goes slowly, stops, and has settled there.
TEST(LoneArm, IsNearToWhatASlowMotionSettlesTo) {
  const std::string clip = "rig.clip.keys={elbow=[[1,0],[75,90],[95,90],[125,130],[145,130]]}";
  const Model slow = arm({clip, "scene.frames=1-145"});
  const Model lone = arm({clip, "scene.frames=1-145", "solver.integrator=quasi_static"});
  Parallel parallel(2);
  State state = initial_state(slow), alone;
  StageSeconds unused;
  settle(slow, parallel, state);
  for (int frame = slow.first_frame; frame <= slow.last_frame; ++frame) {
    if (frame > slow.first_frame) {
      step_frame(slow, (frame - slow.first_frame) / slow.fps, parallel, state, unused);
    }
    if (frame != 1 && frame != 95 && frame != 145) continue;
    solve(lone, frame, alone);
    const Distances apart = between(state, alone);
    std::printf("frame %d: muscles %.3f, skin %.3f mm apart\n", frame, 1e3 * apart.muscles,
                1e3 * apart.skin);
    EXPECT_EQ(apart.bones, 0.0);
    EXPECT_LT(apart.muscles, 5e-4) << frame;
    EXPECT_LT(apart.skin, 1e-3) << frame;
  }
}

}  // namespace
}  // namespace thew::tests
