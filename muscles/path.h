// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/skeleton.h"

namespace thew {

/// A point that the muscle's line of action passes through, fixed to a body.
struct PathPoint {
  int body = -1;
  Vec3 position = Vec3::Zero();  ///< in the body's frame
};

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
/// nearest the axis. Where touching begins, length and its derivative in the pose are continuous.
struct TracedPath {
  std::vector<Vec3> points;
  double length = 0.0;  ///< m
};
TracedPath trace_path(const MusclePath& path, const Pose& pose);

}  // namespace thew
