// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/kept_out.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/skin/tendon.h"

namespace thew::tests {
namespace {

struct Scene : TendonOverBall {
  std::vector<char> driven;

  // Nodes on the left of `free_from` (share of the length) are driven.
  explicit Scene(double of = 1.0, double free_from = 0.4) : TendonOverBall(of) {
    for (const double along : shape.along) driven.push_back(along < free_from * size * kLength);
    keep_out(bones, {0}, mesh.triangles, driven, pose(0.0), size, shape);
  }
  Points cleared(double up, std::vector<Points>& memory) const {
    Points x = positions(up);
    shape.clear_bones(pose(up), x, memory);
    return x;
  }
  Points cleared(double up) const {
    std::vector<Points> memory;
    return cleared(up, memory);
  }
  // m, of a point in the ball.
  double depth(const Vec3& p, double up) const {
    return size * kBall - (p - size * Vec3(0.05, up - kAway, 0.0)).norm();
  }
  // m, of the driven nodes and of the middles of the faces between them.
  double deepest(const Points& x, double up) const {
    double most = -1.0;
    for (const Triangle& t : mesh.triangles) {
      if (!driven[t[0]] || !driven[t[1]] || !driven[t[2]]) continue;
      for (const int i : t) most = std::max(most, depth(to_vec(x[i]), up));
      most = std::max(most, depth(to_vec((x[t[0]] + x[t[1]] + x[t[2]]) * (1.0 / 3.0)), up));
    }
    return most;
  }
};

TEST(KeptOut, ATendonBesideABoneIsLeftAlone) {
  const Scene scene;
  for (const double up : {0.0, 0.0255, 0.0264}) {  // 26 mm: they touch
    EXPECT_EQ(largest_distance(scene.cleared(up), scene.positions(up)), 0.0) << up;
  }
}

TEST(KeptOut, WhatIsDeeperThanItsLimitIsMovedOutToIt) {
  const Scene scene;
  for (const double up : {0.0268, 0.0272, 0.0275}) {
    EXPECT_GT(scene.deepest(scene.positions(up), up), up - 0.0261) << up;
    EXPECT_LT(scene.deepest(scene.cleared(up), up), 0.7e-3) << up;
  }
}

TEST(KeptOut, NoNodeIsMovedByMoreThanAMillimetre) {
  const Scene scene;
  const double moved = largest_distance(scene.cleared(0.03), scene.positions(0.03));
  EXPECT_NEAR(moved, 1e-3, 1e-9);
}

TEST(KeptOut, NodesThatContactMovesAreLeftToIt) {
  const Scene scene(1.0, 0.15);
  const double up = 0.029;
  const Points x = scene.positions(up), y = scene.cleared(up);
  int moved = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const bool is_moved = to_vec(x[i]) != to_vec(y[i]);
    EXPECT_LE(is_moved, scene.driven[i]) << i;
    moved += is_moved;
  }
  EXPECT_GT(moved, 0);
}

TEST(KeptOut, NodesAreContinuousInThePose) {
  constexpr double kStep = 5e-5;  // m
  const Scene scene;
  Points before = scene.cleared(0.0);
  double most = 0.0;
  for (double up = 0.026; up < 0.0305; up += kStep) {
    const Points now = scene.cleared(up);
    if (up > 0.026) most = std::max(most, largest_distance(now, before));
    before = now;
  }
  EXPECT_GT(most, 0.5 * kStep);
  EXPECT_LT(most, 3.0 * kStep);
}

TEST(KeptOut, WhatItRemembersDoesNotChangeTheResult) {
  const Scene scene;
  std::vector<Points> memory;
  for (int k = 0; k <= 100; ++k) {
    const double up = 0.02 + 0.01 * std::sin(0.2 * k);
    ASSERT_EQ(largest_distance(scene.cleared(up, memory), scene.cleared(up)), 0.0) << k;
  }
}

TEST(KeptOut, ASimilarBodyIsKeptOutSimilarly) {
  const Scene one, twice(2.0);
  const Points x = one.cleared(0.029), y = twice.cleared(0.029);
  EXPECT_GT(largest_distance(x, one.positions(0.029)), 0.9e-3);
  for (size_t i = 0; i < x.size(); ++i) {
    ASSERT_LT((2.0 * to_vec(x[i]) - to_vec(y[i])).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace thew::tests
