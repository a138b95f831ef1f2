// SPDX-License-Identifier: Apache-2.0
#include "rig/character_limbs.h"

#include <gtest/gtest.h>

#include "rig/math.h"

namespace thew::tests {
namespace {

// A right arm: x forward, y up, z outward; the carrier lies beside the shoulder joint.
struct Shoulder {
  Scapula scapula{0, 1, 2, -Vec3::UnitX(), -Vec3::UnitY(), 30.0 * kDegree, 1.0 / 3.0, {}};
  Pose pose = Pose(3, Transform::Identity());

  Shoulder() {
    scapula.at_rest = Transform::Identity();
    scapula.at_rest.translation() = Vec3(0.01, 0.02, 0.15);
    pose[1].linear() = rotation_about(Vec3::UnitZ(), 0.4);
    pose[1].translation() = Vec3(0.3, 1.4, 0.0);
  }
  // With the humerus raised by a turn in the carrier's frame.
  const Transform& raise(const Mat3& turn) {
    pose[2] = pose[1] * scapula.at_rest * Transform(turn);
    pose_scapula(scapula, pose);
    return pose[0];
  }
};

// Inman, Saunders, Abbott 1944: of the elevation beyond 30 degrees a third is the scapula's.
TEST(Scapula, TakesAThirdOfTheElevationInAnyPlane) {
  Shoulder shoulder;
  EXPECT_LT((shoulder.raise(Mat3::Identity()).matrix() - shoulder.pose[1].matrix()).norm(), 1e-12);
  for (const double plane : {0.0, 0.7, 1.5, 2.4}) {
    const auto [s, c] = sin_cos(plane);
    for (const double degrees : {60.0, 90.0, 150.0}) {
      const Mat3 raised = rotation_about(Vec3(-c, 0.0, s), degrees * kDegree);
      const Transform blade = shoulder.raise(raised * rotation_about(Vec3::UnitY(), 0.8));
      const Mat3 turn = shoulder.pose[1].linear().transpose() * blade.linear();
      const Mat3 expected = rotation_about(-Vec3::UnitX(), (degrees - 30.0) / 3.0 * kDegree);
      EXPECT_LT((turn - expected).norm(), 1e-9) << degrees;
      // Its socket stays at the humerus' head.
      EXPECT_LT(
          (blade * shoulder.scapula.at_rest.translation() - shoulder.pose[2].translation()).norm(),
          1e-12);
    }
  }
  // Upwards is outwards: what lies below the joint goes away from the trunk.
  const Transform raised = shoulder.raise(rotation_about(-Vec3::UnitX(), 90.0 * kDegree));
  const Vec3 tip = shoulder.scapula.at_rest.translation() - Vec3(0.0, 0.1, 0.0);
  EXPECT_GT((shoulder.pose[1].inverse() * (raised * tip)).z(), tip.z() + 0.02);
}

TEST(Scapula, TurnsSmoothlyThroughTheHangingArm) {
  Shoulder shoulder;
  const double step = 0.05 * kDegree;
  Vec3 before = Vec3::Zero(), slope = before;
  for (int k = -1500; k <= 1500; ++k) {
    const Vec3 tip =
        shoulder.raise(rotation_about(-Vec3::UnitX(), k * step)) * Vec3(0.0, -0.1, 0.1);
    const Vec3 moved = tip - before;
    if (k > -1499) EXPECT_LT((moved - slope).norm(), 1e-7) << k;  // m
    before = tip;
    slope = moved;
  }
}

}  // namespace
}  // namespace thew::tests
