// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/skeleton.h"

namespace thew::muscles {

/// A point that the muscle's line of action passes through, fixed to a body, or between two: then
/// it goes where its body's origin goes, but takes only a share of how the body has turned against
/// `with` since rest.
struct PathPoint {
  int body = -1;
  Vec3 position = Vec3::Zero();     ///< in the body's frame
  int with = -1;                    ///< another body; -1: none
  double share = 1.0;               ///< of the turn, 0..1
  Mat3 at_rest = Mat3::Identity();  ///< the body's turn in `with`, in the pose of the mesh
};
/// Makes the point one between its body and `with`, at rest in `rest_pose`.
void share_turn(int with, double share, const Pose& rest_pose, PathPoint& point);
/// The frame that carries it: the body's own, or one that has turned by the share. Continuous in
/// any pose: from a turn of 120 degrees on the share rises to 1 at 180, where the axis changes
/// sign.
Transform place_of(const PathPoint& point, const Pose& pose);

/// A cylinder, fixed to a body, round which the segment between points `segment` and `segment + 1`
/// bends; `turn` is +1 or -1: the sense of rotation, seen against `axis` (from its tip), in which
/// it goes round; +1 is counter-clockwise. One wrap a segment. A point within the radius counts as
/// lying on the surface.
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

/// Points of the polyline between the two ends of a wrapped segment.
inline constexpr int kArcPoints = 17;

/// The musculotendon path at a pose: a polyline in the world and its exact length (tangents and
/// helical arcs, not the polyline's). Each wrap contributes kArcPoints points at any pose, so their
/// number never changes; where the segment does not touch its cylinder they all lie on the point
/// nearest the axis. Points and length are continuous in the pose, and where touching begins so is
/// the length's derivative. An end that goes round so far that the segment would pass the cylinder
/// on the wrong side takes it off again: gradually, from an angle of 60 degrees at an end between
/// segment and axis, to the straight line at 90.
struct TracedPath {
  std::vector<Vec3> points;
  std::vector<int> of_point;  ///< by point of the path, which of `points` it is
  double length = 0.0;        ///< m
};
TracedPath trace_path(const MusclePath& path, const Pose& pose);
void trace_path(const MusclePath& path, const Pose& pose, TracedPath& traced);

}  // namespace thew::muscles
