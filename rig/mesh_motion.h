// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/mesh.h"
#include "rig/skeleton.h"

namespace thew::rig {

/// Positions of a mesh at given times, as a file has them. Its triangles never change.
struct MeshSamples {
  std::vector<double> times;                 ///< s, increasing; 0 at the first
  std::vector<std::vector<Vec3>> positions;  ///< m, by sample and vertex
};

/// The motion of a mesh: a rigid one and, where the mesh bends, what that leaves. Between samples
/// the rigid motion is a screw and the rest linear; before the first and after the last it stays.
struct MeshMotion {
  std::vector<double> times;  ///< s of the clip, increasing
  Pose poses;  ///< by sample, the rigid motion nearest to it, from the rest positions
  std::vector<Points> shapes;  ///< m, by sample, positions before that motion; empty: it is rigid
  double bend = 0.0;           ///< m, farthest that a vertex lies from its rigid motion
  int bent_most = 0;           ///< the sample in which it does
};

/// A vertex that lies no farther (m) from its rigid motion moves with it. Float32, in which caches
/// are stored, rounds by half of that at 10 m.
inline constexpr double kRigid = 1e-6;

/// The rigid motion that takes points to others with the least sum of squared distances (Kabsch
/// 1976).
Transform nearest_motion(const std::vector<Vec3>& from, const std::vector<Vec3>& to);
/// `begin`: s of the clip at the first sample.
MeshMotion motion_of(const std::vector<Vec3>& rest, const MeshSamples& samples, double begin);

/// The screw motion from a to b, at a share [0..1] of its way: a turn about one axis in space and a
/// way along it. A hinge's motion is one, wherever the frames have their origins.
Transform between(const Transform& a, const Transform& b, double share);
Transform pose_at(const MeshMotion& motion, double time);
/// Positions before the motion of pose_at(); the motion must have shapes.
void shape_at(const MeshMotion& motion, double time, Points& x);

}  // namespace thew::rig
