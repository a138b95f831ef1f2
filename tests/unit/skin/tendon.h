// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "muscles/carried_shape.h"
#include "muscles/tube.h"
#include "skin/contact/rigid_bone.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {

inline constexpr double kLength = 0.3, kTendon = 0.004, kBall = 0.02;  // m
inline constexpr double kAway = 0.05;                                  // m, of the ball at rest

/// A straight muscle of `size` with long tendons from body 0 to body 1, and below it a ball on body
/// 2, that is not fixed to it.
struct TendonOverBall {
  double size;
  TriMesh mesh;
  muscles::CarriedShape shape;
  std::shared_ptr<std::vector<skin::RigidBone>> bones;

  explicit TendonOverBall(double of = 1.0, double ball_at = 0.05) : size(of) {
    using namespace muscles;
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
    bones = std::make_shared<std::vector<skin::RigidBone>>(
        1, skin::rigid_bone(2, surface, to_points(bone.vertices)));
  }
  /// With the ball moved up (m, of a man).
  Pose pose(double up) const {
    Pose pose(3, Transform::Identity());
    pose[2].translate(Vec3(0.0, size * up, 0.0));
    return pose;
  }
  /// Of the carried shape, m.
  Points positions(double up) const {
    Points x;
    carried_positions(shape, muscles::carry_pose(shape, pose(up)), true, x);
    return x;
  }
};

}  // namespace thew::tests
