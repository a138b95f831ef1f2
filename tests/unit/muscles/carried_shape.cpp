// SPDX-License-Identifier: Apache-2.0
#include "muscles/carried_shape.h"

#include <gtest/gtest.h>

#include "muscles/tube.h"
#include "muscles/volume.h"
#include "muscles/weights.h"
#include "rig/math.h"

namespace thew::tests {
namespace {

Pose two_bodies(double x, double angle) {
  Pose pose(2, Transform::Identity());
  pose[1].translate(Vec3(x, 0, 0));
  pose[1].rotate(rotation_about(Vec3::UnitX(), angle));
  return pose;
}

MusclePath straight_path() {
  MusclePath path;
  path.points = {{0, Vec3::Zero()}, {1, Vec3(0.3, 0, 0)}};
  return path;
}

TriMesh spindle() {
  return make_tube(trace_path(straight_path(), two_bodies(0, 0)), 20, 31,
                   {{0.0, 0.004}, {0.2, 0.004}, {0.5, 0.018}, {0.8, 0.004}, {1.0, 0.004}});
}

CarriedShape make_shape(const TriMesh& mesh, const WeightProfile& profile,
                        double twist_from = 0.0) {
  const std::array<double, 2> belly = {0.06, 0.24};
  const Pose rest = two_bodies(0, 0);
  return make_carried_shape(
      mesh, straight_path(), rest, belly,
      profile_weights(profile, belly_coordinates(mesh, straight_path(), rest, belly)), twist_from);
}

double volume_of(const Points& x, const TriMesh& mesh) {
  return enclosed_volume(x, mesh.triangles);
}

TEST(CarriedShape, AtRestIsTheRestShape) {
  const TriMesh mesh = spindle();
  const CarriedShape shape = make_shape(mesh, preset_profile("left"));
  Points x;
  carried_positions(shape, carry_pose(shape, two_bodies(0, 0)), true, x);
  for (size_t i = 0; i < x.size(); ++i) {
    EXPECT_LT((to_vec(x[i]) - mesh.vertices[i]).norm(), 1e-12);
  }
}

TEST(CarriedShape, ShortenedAndLengthenedItKeepsItsVolume) {
  const TriMesh mesh = spindle();
  for (const char* profile : {"left", "even", "right"}) {
    const CarriedShape shape = make_shape(mesh, preset_profile(profile));
    const double rest = enclosed_volume(mesh);
    for (double change : {-0.06, -0.02, 0.03, 0.08}) {
      Points x;
      carried_positions(shape, carry_pose(shape, two_bodies(change, 0)), true, x);
      EXPECT_NEAR(volume_of(x, mesh) / rest, 1.0, 0.02) << profile << " " << change;
    }
  }
}

TEST(CarriedShape, TendonsKeepTheirLength) {
  const TriMesh mesh = spindle();
  const CarriedShape shape = make_shape(mesh, WeightProfile{});
  const CarriedPose pose = carry_pose(shape, two_bodies(-0.05, 0));
  EXPECT_NEAR(pose.path_length, 0.25, 1e-12);
  Vec3 from, to, tangent;
  curve_at(shape, pose, 0.06, from, tangent);
  curve_at(shape, pose, 0.24, to, tangent);
  EXPECT_NEAR(from.x(), 0.06, 1e-12);
  EXPECT_NEAR(to.x(), 0.19, 1e-12);
}

TEST(CarriedShape, MovesRigidlyWithItsBodies) {
  const TriMesh mesh = spindle();
  const CarriedShape shape = make_shape(mesh, preset_profile("right"));
  Transform move = Transform::Identity();
  move.translate(Vec3(0.1, -0.4, 0.2));
  move.rotate(rotation_about(Vec3(1, 2, 3).normalized(), 0.8));
  Pose still = two_bodies(-0.03, 0.2), moved = still;
  for (Transform& body : moved) body = move * body;
  Points a, b, unscaled;
  carried_positions(shape, carry_pose(shape, still), true, unscaled, 0.96, &a);
  carried_positions(shape, carry_pose(shape, moved), true, unscaled, 0.96, &b);
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT((move * to_vec(a[i]) - to_vec(b[i])).norm(), 1e-12);
  }
}

TEST(CarriedShape, TwistOfTheInsertionIsSharedOut) {
  const TriMesh mesh = spindle();
  const CarriedShape shape = make_shape(mesh, WeightProfile{});
  const CarriedPose plain = carry_pose(shape, two_bodies(0, 0));
  const CarriedPose twisted = carry_pose(shape, two_bodies(0, 1.0));
  const size_t middle = plain.curve.samples.size() / 2;
  const Vec3 n = to_vec(plain.curve.samples[middle].normal);
  const Vec3 t = to_vec(twisted.curve.samples[middle].normal);
  EXPECT_NEAR(n.dot(t), sin_cos(0.5).cos, 1e-9);
  EXPECT_NEAR(n.cross(t).x(), sin_cos(0.5).sin, 1e-9);
}

TEST(CarriedShape, TwistBeginsWhereItIsTold) {
  const TriMesh mesh = spindle();
  const CarriedShape shape = make_shape(mesh, WeightProfile{}, 0.225);
  ASSERT_NEAR(shape.rest_path_length, 0.3, 1e-12);
  const CarriedPose plain = carry_pose(shape, two_bodies(0, 0));
  const CarriedPose twisted = carry_pose(shape, two_bodies(0, 1.0));
  const size_t last = plain.curve.samples.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    const double angle = std::max(4.0 * i / last - 3.0, 0.0);  // from three quarters on
    const Vec3 n = to_vec(plain.curve.samples[i].normal);
    const Vec3 t = to_vec(twisted.curve.samples[i].normal);
    EXPECT_NEAR(n.dot(t), sin_cos(angle).cos, 1e-9) << i;
    EXPECT_NEAR(n.cross(t).x(), sin_cos(angle).sin, 1e-9) << i;
  }
}

// Results in m: the largest motion of a node while the insertion turns by an eighth of a degree,
// over a full turn in such steps; and the distance of the middle of the belly from its first
// position after the full turn. Without a tendon that lets go it would jump at 180 degrees by the
// width of the belly.
double largest_step(const CarriedShape& shape, const Vec3& axis, double& from_start) {
  Points x, before, start;
  double most = 0.0;
  for (int k = 0; k <= 8 * 360; ++k) {
    Pose pose = two_bodies(0, 0);
    pose[1].translation() = Vec3(0.3, 0, 0);
    pose[1].linear() = rotation_about(axis, k * 0.125 * kDegree);
    carried_positions(shape, carry_pose(shape, pose), true, x);
    if (k == 0) start = x;
    if (k > 0) most = std::max(most, largest_distance(x, before));
    before = x;
  }
  from_start = largest_distance(x, start);
  return most;
}

TEST(CarriedShape, ABodyThatTurnsRightRoundDoesNotMakeItLeap) {
  const TriMesh mesh = spindle();
  const std::array<double, 2> belly = {0.06, 0.24};
  MusclePath path = straight_path();
  path.points.back() = {1, Vec3::Zero()};
  Pose rest = two_bodies(0, 0);
  rest[1].translation() = Vec3(0.3, 0, 0);
  for (double twist_from : {0.0, 0.225}) {
    const CarriedShape shape = make_carried_shape(
        mesh, path, rest, belly, std::vector<double>(mesh.vertices.size(), 1.0), twist_from);
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(1, 0.2, 0), Vec3(1, -0.4, 0.5)}) {
      double from_start = 0.0;
      const double most = largest_step(shape, axis.normalized(), from_start);
      EXPECT_LT(most, 0.5e-3) << axis.transpose() << " from " << twist_from;
      EXPECT_LT(from_start, 1e-9);
    }
  }
}

}  // namespace
}  // namespace thew::tests
