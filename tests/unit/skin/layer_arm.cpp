// SPDX-License-Identifier: Apache-2.0
//
// The skin over a made-up arm that flexes by 115 degrees within 40 frames, comes back and rests.
// (Beyond that angle its bellies, which have no contact with one another, overlap and leave no room
// for skin.)
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/skin/arm.h"

namespace thew::tests {
namespace {

constexpr int kFrames = 40, kRest = 24;
constexpr double kFlexed = 115.0;  // degrees

struct Flexed {
  TestArm arm;
  SkinModel model;
  SkinState state;
  SkinMetrics worst;
  int folds = 0;             // that the flexed arm's walls have
  double coming_back = 0.0;  // m, distance from the rest shape at the end

  explicit Flexed(bool keeps_volume)
      : model(arm.bind({.iterations = 12, .keeps_volume = keeps_volume})),
        state(initial_skin(model)) {
    for (int frame = 0; frame <= 2 * kFrames + kRest; ++frame) {
      const double share = 1.0 - std::abs(frame - kFrames) / double(kFrames);
      const double degrees = kFlexed * std::max(share, 0.0);
      arm.move_to(degrees);
      step_skin(model, arm.pose(degrees), arm.colliders(), {}, state);
      if (frame == kFrames) folds = static_cast<int>(state.folds.size());
      if (frame % 4 != 0) continue;
      const SkinMetrics last = measure_skin(model, arm.colliders(), state);
      worst.max_penetration = std::max(worst.max_penetration, last.max_penetration);
      worst.max_poke_through = std::max(worst.max_poke_through, last.max_poke_through);
      worst.intersecting_pairs = std::max(worst.intersecting_pairs, last.intersecting_pairs);
      worst.volume_error = std::max(worst.volume_error, last.volume_error);
    }
    for (size_t i = 0; i < model.rest.size(); ++i) {
      coming_back = std::max(coming_back, to_vec(state.x[i] - model.rest[i]).norm());
    }
  }
};

class SkinLayer : public testing::TestWithParam<bool> {
 protected:
  static const Flexed& flexed() {
    static const Flexed free(false), full(true);
    return GetParam() ? full : free;
  }
};

TEST_P(SkinLayer, NothingPokesThroughAndNoNodeIsInside) {
  EXPECT_LE(flexed().worst.max_penetration, 0.0);
  EXPECT_LE(flexed().worst.max_poke_through, 5e-4);
}

TEST_P(SkinLayer, TheWallsOfTheElbowsFoldAreFoundAndKeptApart) {
  EXPECT_GT(flexed().folds, 10);
  EXPECT_EQ(flexed().worst.intersecting_pairs, 0);
}

TEST_P(SkinLayer, ComesBackToItsRestShapeWithinASecond) { EXPECT_LE(flexed().coming_back, 1e-3); }

TEST_P(SkinLayer, KeepsItsVolumeWhereItIsAskedTo) {
  if (GetParam()) {
    EXPECT_LE(flexed().worst.volume_error, 1e-12);
  } else {
    EXPECT_GE(flexed().worst.volume_error, 0.01);  // otherwise the test would show nothing
  }
}

INSTANTIATE_TEST_SUITE_P(, SkinLayer, testing::Bool());

TEST(SkinNormals, AreThoseOfTheSkinItself) {
  // Normals are averaged over the neighbours alone, so on a ball each points away from the centre.
  const TriMesh mesh = ball(0.1, Vec3::Zero(), 32, 31);
  const Shape below = make_shape(ball(0.09, Vec3::Zero(), 32, 31));
  Skeleton skeleton;
  skeleton.body_names = {"bone"};
  skeleton.parent = {-1};
  const std::vector<Collider> colliders = {{&below.surface, &below.bvh, &below.x, nullptr}};
  const Pose pose = {Transform::Identity()};
  const SkinModel model = bind_skin(mesh, skeleton, pose, colliders, {0}, {});
  SkinState state = initial_skin(model);
  step_skin(model, pose, colliders, {}, state);
  for (size_t i = 0; i < state.x.size(); ++i) {
    EXPECT_GT(to_vec(state.normals[i]).dot(to_vec(state.x[i]).normalized()), 0.99);
  }
}

}  // namespace
}  // namespace thew::tests
