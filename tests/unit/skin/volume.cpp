// SPDX-License-Identifier: Apache-2.0
//
// The volume of a skin that keeps its volume: a ball of skin around a ball of flesh that grows,
// where the answer is known.
#include "muscles/volume.h"

#include <gtest/gtest.h>

#include "skin/skin_layer.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kSkin = 0.05, kFlesh = 0.045;  // m, radii at rest

struct Growing {
  Shape flesh = make_shape(ball(kFlesh, Vec3::Zero(), 32, 31));
  std::vector<Collider> below = {{&flesh.surface, &flesh.bvh, &flesh.x, nullptr}};
  SkinModel model;
  SkinState state;

  explicit Growing(bool keeps_volume) {
    Skeleton skeleton;
    skeleton.body_names = {"bone"};
    skeleton.parent = {-1};
    model = bind_skin(ball(kSkin, Vec3::Zero(), 32, 31), skeleton, {Transform::Identity()}, below,
                      {0}, {.thickness = 0.001, .iterations = 12, .keeps_volume = keeps_volume});
    state = initial_skin(model);
  }

  void grow_to(double radius, const Vec3& shift = Vec3::Zero()) {
    constexpr int kFrames = 30;
    for (int frame = 1; frame <= 2 * kFrames; ++frame) {  // the second half at rest
      const double share = std::min(frame, kFrames) / double(kFrames);
      const TriMesh grown = ball(kFlesh + share * (radius - kFlesh), share * shift, 32, 31);
      for (size_t i = 0; i < flesh.x.size(); ++i) flesh.x[i] = to_point(grown.vertices[i]);
      refit_bvh(flesh.surface, flesh.x, flesh.bvh);
      step_skin(model, {Transform::Identity()}, below, {}, state);
    }
  }

  double least_radius() const {
    double least = 1.0;
    for (const Point& x : state.x) least = std::min(least, norm(x));
    return least;
  }
  double largest_radius() const {
    double most = 0.0;
    for (const Point& x : state.x) most = std::max(most, norm(x));
    return most;
  }
  double volume() const { return enclosed_volume(state.x, model.surface.triangles); }
};

TEST(SkinVolume, FatThatFleshPressesFromWithinHasNowhereToGo) {
  // 5 mm of fat over flesh that grows by 3 mm. If all fat is kept the skin has a radius of 53 mm;
  // at constant volume it has 50 mm and the fat becomes thinner.
  Growing free(false), full(true);
  free.grow_to(kFlesh + 0.003);
  full.grow_to(kFlesh + 0.003);
  EXPECT_NEAR(free.least_radius(), kSkin + 0.003, 3e-4);
  EXPECT_NEAR(full.least_radius(), kSkin, 2e-4);
  EXPECT_NEAR(full.largest_radius(), kSkin, 2e-4);
  EXPECT_NEAR(full.volume() / full.model.volume, 1.0, 1e-13);
}

TEST(SkinVolume, WhatIsPressedOutOnOneSideIsMissedOnTheOther) {
  // Flesh that moves to one side by 3 mm leaves 2 mm of fat there, if the skin stays a ball. The
  // skin may follow, but it keeps its volume and is nowhere nearer to the flesh than its thickness.
  Growing full(true);
  full.grow_to(kFlesh, Vec3(0.003, 0.0, 0.0));
  EXPECT_NEAR(full.volume() / full.model.volume, 1.0, 1e-13);
  const SkinMetrics metrics = measure_skin(full.model, full.below, full.state);
  EXPECT_EQ(metrics.max_penetration, 0.0);
  EXPECT_LE(metrics.max_poke_through, 0.0);
  EXPECT_LE(metrics.volume_error, 1e-13);
}

TEST(SkinVolume, NoRoomIsStatedAndTheFleshStaysCovered) {
  // Flesh of 52 mm does not fit into a skin of 50 mm: the skin lies on it, and its volume error is
  // reported.
  Growing full(true);
  full.grow_to(0.052);
  const SkinMetrics metrics = measure_skin(full.model, full.below, full.state);
  EXPECT_EQ(metrics.max_penetration, 0.0);
  EXPECT_EQ(metrics.intersecting_pairs, 0);
  EXPECT_GE(metrics.volume_error, std::pow(0.052 / kSkin, 3) - 1.0);
  EXPECT_LE(metrics.volume_error, std::pow(0.0545 / kSkin, 3) - 1.0);
  full.grow_to(kFlesh);  // it has its own volume again as soon as there is room
  EXPECT_NEAR(full.volume() / full.model.volume, 1.0, 1e-13);
}

}  // namespace
}  // namespace thew::tests
