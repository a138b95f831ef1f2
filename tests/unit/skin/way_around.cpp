// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/way_around.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/skin/tendon.h"

namespace thew::tests {
namespace {

using namespace muscles;

struct Scene : TendonOverBall {
  explicit Scene(double of = 1.0, double ball_at = 0.05) : TendonOverBall(of, ball_at) {
    pass_around(bones, {0}, pose(0.0), size, shape);
  }
  // m, of the curve from the ball's centre.
  double nearest(double up, double ball_at = 0.05) const {
    double least = 1e9;
    for (const CurveSample& sample : carry_pose(shape, pose(up)).curve.samples) {
      const Vec3 centre = size * Vec3(ball_at, up - kAway, 0.0);
      least = std::min(least, (to_vec(sample.point) - centre).norm());
    }
    return least;
  }
};

TEST(WayAround, ATendonThatABoneDoesNotReachIsCarriedAsWithoutIt) {
  const Scene scene;
  CarriedShape without = scene.shape;
  without.give_way = nullptr;
  for (const double up : {0.0, 0.015, 0.026}) {
    Points x;
    carried_positions(without, carry_pose(without, scene.pose(up)), true, x);
    const Points with = scene.positions(up);
    for (size_t i = 0; i < x.size(); ++i) ASSERT_EQ(to_vec(with[i]), to_vec(x[i])) << up;
  }
}

TEST(WayAround, ATendonPassesAroundABoneByItsThickness) {
  const Scene scene;
  for (const double up : {0.03, 0.034, 0.038}) {
    // Left alone up to 0.8 mm nearer.
    EXPECT_GT(scene.nearest(up), kBall + kTendon - 0.9e-3) << up;
    const CarriedPose carried = carry_pose(scene.shape, scene.pose(up));
    EXPECT_LT(to_vec(carried.curve.samples.front().point).norm(), 1e-12);
    EXPECT_LT((to_vec(carried.curve.samples.back().point) - Vec3(kLength, 0, 0)).norm(), 1e-12);
    EXPECT_GT(carried.path_length, kLength + 1e-4);
    EXPECT_NEAR(carried.change, carried.path_length - kLength, 1e-12);
  }
}

TEST(WayAround, ABellyIsLeftToContact) {
  const Scene scene(1.0, 0.5 * kLength);
  EXPECT_NEAR(scene.nearest(0.038, 0.5 * kLength), kAway - 0.038, 1e-4);
}

TEST(WayAround, TheCurveIsContinuousInThePose) {
  // Up to a depth of 8 mm. Near the middle of a bone the nearest face leaps, and with it the
  // direction out of it.
  constexpr double kStep = 1e-4, kHighest = 0.038;  // m
  const Scene scene;
  Points before = scene.positions(0.0);
  double most = 0.0;
  for (double up = kStep; up < kHighest; up += kStep) {
    const Points now = scene.positions(up);
    for (size_t i = 0; i < now.size(); ++i) {
      most = std::max(most, (to_vec(now[i]) - to_vec(before[i])).norm());
    }
    before = now;
  }
  EXPECT_GT(most, 0.5 * kStep);
  EXPECT_LT(most, 4.0 * kStep);
}

TEST(WayAround, WhatItRemembersDoesNotChangeTheResult) {
  const Scene scene;
  CarryWork kept;
  for (int k = 0; k <= 200; ++k) {
    const Pose pose = scene.pose(0.0225 + 0.0225 * std::sin(0.1 * k));
    CarriedPose with, without = carry_pose(scene.shape, pose);
    carry_pose(scene.shape, pose, kept, with);
    for (size_t i = 0; i < with.curve.samples.size(); ++i) {
      ASSERT_EQ(to_vec(with.curve.samples[i].point), to_vec(without.curve.samples[i].point)) << k;
    }
  }
}

TEST(WayAround, ASimilarBodyIsLedSimilarly) {
  const Scene one, twice(2.0);
  const Points x = one.positions(0.04), y = twice.positions(0.04);
  for (size_t i = 0; i < x.size(); ++i) {
    ASSERT_LT((2.0 * to_vec(x[i]) - to_vec(y[i])).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace thew::tests
