// SPDX-License-Identifier: Apache-2.0
// Rigid motions that are found from positions, and the screw between two.
#include "rig/mesh_motion.h"

#include <gtest/gtest.h>

#include "rig/math.h"

namespace thew::rig {
namespace {

const std::vector<Vec3> kRest = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.2, 0}, {0, 0, 0.3}, {0.1, 0.1, 0.1}};

Transform turned(const Vec3& axis, double angle, const Vec3& about) {
  Transform out = Transform::Identity();
  out.linear() = rotation_about(axis.normalized(), angle);
  out.translation() = about - out.linear() * about;
  return out;
}

std::vector<Vec3> moved(const Transform& motion) {
  std::vector<Vec3> out;
  for (const Vec3& p : kRest) out.push_back(motion * p);
  return out;
}

TEST(MeshMotion, TheNearestMotionIsTheOneThatWasMade) {
  for (const double angle : {0.0, 1e-9, 0.3, 2.0, 3.14159}) {
    Transform made = turned(Vec3(1, 2, -3), angle, Vec3(0.4, -1, 2));
    made.translation() += Vec3(5, 0, -7);
    const Transform found = nearest_motion(kRest, moved(made));
    EXPECT_LT((found.matrix() - made.matrix()).norm(), 1e-13) << angle;
  }
}

TEST(MeshMotion, APlateIsNeverMirrored) {
  const std::vector<Vec3> plate = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const Transform made = turned(Vec3(1, 0.2, 0), 2.9, Vec3(0, 0, 1));
  std::vector<Vec3> to;
  for (const Vec3& p : plate) to.push_back(made * p);
  const Transform found = nearest_motion(plate, to);
  EXPECT_NEAR(found.linear().determinant(), 1.0, 1e-14);
  EXPECT_LT((found.matrix() - made.matrix()).norm(), 1e-13);
}

// A hinge far from the origin of the frames: half of its way is half of its turn.
TEST(MeshMotion, AHingesScrewIsTheHinge) {
  const Vec3 axis(0.2, 1, 0.4), about(3, -2, 1);
  const Transform a = turned(axis, 0.2, about);
  for (const double angle : {1e-9, 0.01, 2.2}) {
    const Transform b = turned(axis, 0.2 + angle, about);
    for (const double share : {0.0, 0.25, 0.5, 1.0}) {
      const Transform wanted = turned(axis, 0.2 + share * angle, about);
      EXPECT_LT((between(a, b, share).matrix() - wanted.matrix()).norm(), 1e-13)
          << angle << " " << share;
    }
  }
}

TEST(MeshMotion, WhatBendsKeepsItsSamplesToRounding) {
  const Transform to = turned(Vec3(0, 0, 1), 1.0, Vec3(1, 1, 1));
  MeshSamples samples{{0.0, 0.5}, {kRest, moved(to)}};
  EXPECT_TRUE(motion_of(kRest, samples, 0.0).shapes.empty());
  samples.positions[1][2] += Vec3(0.02, 0, 0);
  const MeshMotion motion = motion_of(kRest, samples, 1.0);
  EXPECT_EQ(motion.bent_most, 1);
  EXPECT_NEAR(motion.bend, 0.02, 0.01);
  Points shape;
  shape_at(motion, 1.5, shape);
  for (size_t i = 0; i < kRest.size(); ++i) {
    EXPECT_LT((pose_at(motion, 1.5) * to_vec(shape[i]) - samples.positions[1][i]).norm(), 1e-15);
  }
  EXPECT_EQ(pose_at(motion, 0.0).matrix(), motion.poses[0].matrix());
  EXPECT_EQ(pose_at(motion, 9.0).matrix(), motion.poses[1].matrix());
}

}  // namespace
}  // namespace thew::rig
