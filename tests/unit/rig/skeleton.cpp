// SPDX-License-Identifier: Apache-2.0
#include "rig/skeleton.h"

#include <gtest/gtest.h>

#include "rig/math.h"

namespace thew::tests {
namespace {

// A planar arm: shoulder at the origin, elbow 0.3 m below it, a slide 0.25 m further on.
Skeleton planar_arm() {
  Skeleton s;
  s.body_names = {"torso", "humerus", "ulna", "hand"};
  s.parent = {-1, 0, 1, 2};
  s.joint_names = {"", "shoulder", "elbow", "slide"};
  using Type = Skeleton::JointType;
  s.joint_types = {Type::kFixed, Type::kRevolute, Type::kRevolute, Type::kPrismatic};
  s.joint_axes = {Vec3::UnitX(), Vec3::UnitZ(), Vec3::UnitZ(), -Vec3::UnitY()};
  s.joint_in_parent.assign(4, Transform::Identity());
  s.joint_in_parent[2].translation() = Vec3(0.0, -0.3, 0.0);
  s.joint_in_parent[3].translation() = Vec3(0.0, -0.25, 0.0);
  s.lower.assign(4, -3.0);
  s.upper.assign(4, 3.0);
  s.visuals.resize(4);
  return s;
}

Vec3 hand_at(const Skeleton& s, double shoulder, double elbow, double slide) {
  Pose pose;
  forward_kinematics(s, {99.0, shoulder, elbow, slide}, pose);  // the root's value is ignored
  return pose[3].translation();
}

TEST(ForwardKinematics, HandComputedCases) {
  const Skeleton s = planar_arm();
  EXPECT_LT((hand_at(s, 0, 0, 0) - Vec3(0, -0.55, 0)).norm(), 1e-15);
  EXPECT_LT((hand_at(s, 0, kPi / 2, 0) - Vec3(0.25, -0.3, 0)).norm(), 1e-15);
  EXPECT_LT((hand_at(s, kPi / 2, 0, 0) - Vec3(0.55, 0, 0)).norm(), 1e-15);
  EXPECT_LT((hand_at(s, kPi / 2, kPi / 2, 0) - Vec3(0.3, 0.25, 0)).norm(), 1e-15);
  EXPECT_LT((hand_at(s, 0, kPi / 2, 0.1) - Vec3(0.35, -0.3, 0)).norm(), 1e-15);
}

TEST(ForwardKinematics, FixedJointIgnoresItsValue) {
  Skeleton s = planar_arm();
  s.joint_types[2] = Skeleton::JointType::kFixed;
  EXPECT_LT((hand_at(s, 0, kPi / 2, 0) - Vec3(0, -0.55, 0)).norm(), 1e-15);
}

TEST(ForwardKinematics, RestFrameTurnsTheAxis) {
  Skeleton s = planar_arm();  // the elbow's frame turned a quarter about x: its z is -y of the body
  s.joint_in_parent[2].linear() = rotation_about(Vec3::UnitX(), kPi / 2.0);
  Pose pose;
  forward_kinematics(s, {0, 0, kPi / 2.0, 0}, pose);
  const Vec3 x = pose[2].linear() * Vec3::UnitX();
  EXPECT_LT((x - Vec3::UnitZ()).norm(), 1e-15);
}

TEST(ForwardKinematics, DeepChainDoesNotRecurse) {
  Skeleton s;
  const int n = 200000;
  for (int i = 0; i < n; ++i) s.parent.push_back(i - 1);
  s.body_names.resize(n);
  s.joint_names.resize(n);
  s.joint_types.assign(n, Skeleton::JointType::kPrismatic);
  s.joint_axes.assign(n, Vec3::UnitX());
  s.joint_in_parent.assign(n, Transform::Identity());
  Pose pose;
  forward_kinematics(s, std::vector<double>(n, 0.5), pose);
  EXPECT_EQ(pose.back().translation().x(), 0.5 * n);
}

TEST(Names, FindAndNearest) {
  const Skeleton s = planar_arm();
  EXPECT_EQ(find_body(s, "ulna"), 2);
  EXPECT_EQ(find_joint(s, "elbow"), 2);
  EXPECT_EQ(find_body(s, "elbow"), -1);
  EXPECT_EQ(find_joint(s, ""), -1);
  EXPECT_EQ(nearest_name("elbw", s.joint_names), "elbow");
  EXPECT_EQ(nearest_name("Shoulder", s.joint_names), "shoulder");
  EXPECT_EQ(nearest_name("pelvis_tilt", s.joint_names), "");
  EXPECT_EQ(nearest_name("", s.joint_names), "");
}

}  // namespace
}  // namespace thew::tests
