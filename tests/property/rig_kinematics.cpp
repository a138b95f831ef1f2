// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "rig/math.h"
#include "rig/skeleton.h"

namespace thew::tests {
namespace {

// A chain of n joints about changing axes, with the last body's pose for equal joint values.
Skeleton chain(int n) {
  Skeleton s;
  for (int i = 0; i < n; ++i) {
    s.body_names.push_back("body" + std::to_string(i));
    s.joint_names.push_back(i ? "joint" + std::to_string(i) : "");
    s.parent.push_back(i - 1);
    s.joint_types.push_back(i % 3 == 2 ? Skeleton::JointType::kPrismatic
                                       : Skeleton::JointType::kRevolute);
    s.joint_axes.push_back(Vec3(1.0, 0.3 * i, -0.2 * i + 0.5).normalized());
    Transform rest = Transform::Identity();
    rest.linear() = rotation_about(Vec3(0.2, 1.0, 0.1 * i).normalized(), 0.4 * i);
    rest.translation() = Vec3(0.1, -0.2 * i, 0.05);
    s.joint_in_parent.push_back(rest);
  }
  return s;
}

std::vector<double> some_values(int n, double phase) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(sin_cos(1.7 * i + phase).sin);
  return values;
}

// The tip in the frame of body b depends only on the joints beyond b.
TEST(ForwardKinematics, Composes) {
  const int n = 12;
  const Skeleton s = chain(n);
  for (int b = 1; b < n - 1; ++b) {
    std::vector<double> first = some_values(n, 0.3), second = some_values(n, 1.9);
    for (int i = b + 1; i < n; ++i) second[i] = first[i];
    Pose p, q;
    forward_kinematics(s, first, p);
    forward_kinematics(s, second, q);
    const Transform tip = p[b].inverse() * p[n - 1], same = q[b].inverse() * q[n - 1];
    EXPECT_LT((tip.matrix() - same.matrix()).cwiseAbs().maxCoeff(), 1e-13) << b;
    EXPECT_GT((p[b].matrix() - q[b].matrix()).cwiseAbs().maxCoeff(), 1e-3) << b;
  }
}

TEST(ForwardKinematics, StaysRigid) {
  Pose pose;
  forward_kinematics(chain(200), some_values(200, 0.0), pose);
  const Mat3 r = pose.back().linear();
  EXPECT_LT((r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-12);
}

// d(tip)/d(joint value) against the geometric Jacobian: axis x (tip - joint), or the axis itself.
TEST(ForwardKinematics, DerivativeByFiniteDifferences) {
  const int n = 9;
  const Skeleton s = chain(n);
  const std::vector<double> values = some_values(n, 0.7);
  Pose pose;
  forward_kinematics(s, values, pose);
  for (int i = 0; i < n; ++i) {
    const double h = 1e-6;
    std::vector<double> plus = values, minus = values;
    plus[i] += h;
    minus[i] -= h;
    Pose after, before;
    forward_kinematics(s, plus, after);
    forward_kinematics(s, minus, before);
    const Vec3 measured = (after[n - 1].translation() - before[n - 1].translation()) / (2.0 * h);
    const Vec3 axis = pose[i].linear() * s.joint_axes[i];  // a joint's motion keeps its own axis
    const Vec3 expected = s.joint_types[i] == Skeleton::JointType::kPrismatic
                              ? axis
                              : axis.cross(pose[n - 1].translation() - pose[i].translation());
    EXPECT_LT((measured - expected).norm(), 1e-8) << i;
  }
}

}  // namespace
}  // namespace thew::tests
