// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/way_around.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "muscles/tube.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

using namespace muscles;

constexpr double kLength = 0.3, kTendon = 0.004, kBall = 0.02;  // m
constexpr double kAway = 0.05;                                  // m, of the ball at rest

// A straight muscle of `size` with long tendons from body 0 to body 1, and below it a ball on body
// 2, that is not fixed to it.
struct Scene {
  double size;
  TriMesh mesh;
  CarriedShape shape;

  explicit Scene(double of = 1.0, double ball_at = 0.05) : size(of) {
    MusclePath path;
    path.points = {{0, Vec3::Zero()}, {1, Vec3(size * kLength, 0, 0)}};
    const Pose rest = pose(0.0);
    mesh = make_tube(trace_path(path, rest), 20, 61,
                     {{0.0, size * kTendon},
                      {0.4, size * kTendon},
                      {0.5, size * 0.015},
                      {0.6, size * kTendon},
                      {1.0, size * kTendon}});
    const std::array<double, 2> belly = {0.4 * size * kLength, 0.6 * size * kLength};
    shape =
        make_carried_shape(mesh, path, rest, belly, std::vector<double>(mesh.vertices.size(), 1.0),
                           0.0, times(Lengths{}, size));
    const TriMesh bone = ball(size * kBall, Vec3(size * ball_at, -size * kAway, 0), 40, 31);
    const skin::Surface surface =
        skin::make_surface(bone.triangles, static_cast<int>(bone.vertices.size()));
    pass_around(std::make_shared<std::vector<skin::RigidBone>>(
                    1, skin::rigid_bone(2, surface, to_points(bone.vertices))),
                {0}, rest, size, shape);
  }
  // With the ball moved up (m, of a man).
  Pose pose(double up) const {
    Pose pose(3, Transform::Identity());
    pose[2].translate(Vec3(0.0, size * up, 0.0));
    return pose;
  }
  Points positions(double up) const {
    Points x;
    carried_positions(shape, carry_pose(shape, pose(up)), true, x);
    return x;
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
