// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/skeleton.h"

namespace thew::muscles {

/// A point that the line of action passes through. It is fixed to a body, or shared by two: then it
/// moves with the origin of its body, but takes only a share of the rotation of the body against
/// `with` since the rest pose.
struct PathPoint {
  int body = -1;
  Vec3 position = Vec3::Zero();  ///< m, in the frame of the body
  int with = -1;                 ///< the other body; -1: none
  double share = 1.0;            ///< share of the rotation that the point takes, 0..1
  /// Rotation of the body relative to `with` in the rest pose.
  Mat3 rest_rotation = Mat3::Identity();
};
/// Makes the point one that is shared by its body and `with`; in `rest_pose` its position does not
/// change.
void share_turn(int with, double share, const Pose& rest_pose, PathPoint& point);
/// The frame that carries a point: that of its body, or one that takes its share of the rotation.
/// It is continuous in the pose: between rotations of 120 and 180 degrees the share rises to 1,
/// because at 180 degrees the axis of the rotation changes sign.
Transform frame_of_point(const PathPoint& point, const Pose& pose);

/// A cylinder, fixed to a body, around which the segment between points `segment` and `segment + 1`
/// bends. `turn` is the sense in which the segment goes around: +1 is counter-clockwise, seen from
/// the tip of `axis`, -1 is clockwise. A segment has at most one wrap. A point inside the cylinder
/// is treated as lying on its surface.
struct WrapCylinder {
  int segment = 0;
  int body = -1;
  Vec3 centre = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0.0;
  double turn = 1.0;
};

/// Origin first, insertion last.
struct MusclePath {
  std::vector<PathPoint> points;
  std::vector<WrapCylinder> wraps;
};

/// Number of points of the polyline between the two ends of a wrapped segment.
inline constexpr int kArcPoints = 17;

/// The musculotendon path in a pose: a polyline in the world and its exact length, that of tangents
/// and helical arcs and not of the polyline. Each wrap contributes kArcPoints points in any pose,
/// so that their number never changes; where the segment does not touch its cylinder, they all lie
/// at the point nearest to the axis. Points and length are continuous in the pose, and where the
/// segment begins to touch so is the derivative of the length. If an end goes around so far that
/// the straight segment would pass on the wrong side of the axis, the segment leaves the cylinder
/// gradually: from an angle of 60 degrees at an end between segment and axis, to the straight line
/// at 90 degrees.
struct TracedPath {
  std::vector<Vec3> points;
  std::vector<int> of_point;  ///< for each point of the path, its index in `points`
  double length = 0.0;        ///< m
};
TracedPath trace_path(const MusclePath& path, const Pose& pose);
void trace_path(const MusclePath& path, const Pose& pose, TracedPath& traced);

}  // namespace thew::muscles
