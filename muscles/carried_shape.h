// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/frames.h"
#include "muscles/lengths.h"
#include "muscles/path.h"
#include "rig/mesh.h"

namespace thew::muscles {

/// A point of a curve (m) and its frame.
struct CurveSample {
  Point point, tangent, normal, binormal;
};
/// The traced path with its corners rounded (so a little shorter; places on it are parts of its
/// length, which stand for the same parts of the path's), sampled at equal distances, with a frame
/// per sample that turns as little as possible; the twist left over against the insertion (see
/// share_twist) is shared out evenly beyond `twist_from`. Where the path turns back, or leaves a
/// bone by more than 115 degrees from where it left it at rest, the least turn depends on next to
/// nothing: there frames are those of the bodies along the path instead, see carried_normal.
struct CarryCurve {
  std::vector<CurveSample, AlignedAllocator<CurveSample>> samples;
};

/// How a muscle's rest shape is carried along its present path. Tendons are rigid: the belly, from
/// `belly[0]` to `belly[1]`, takes all the change of length, and swells by what it shortens.
struct CarriedShape {
  MusclePath path;
  std::array<double, 2> belly = {0.0, 0.0};  ///< m along the rest path
  double twist_from = 0.0;                   ///< m along the rest path
  double rest_path_length = 0.0;             ///< m, of the exact path
  Lengths lengths;
  std::array<Mat3, 2> rest_end_frames;  ///< curve's ends in the frames of their bodies
  CurveFrames rest;                     ///< by sample
  /// Points of the path one after the other that one body carries.
  struct Run {
    int first, last;
    Mat3 at_rest;  ///< the body's turn
    Vec3 along;    ///< unit, at rest: from between this run and the one before, the longer way
  };
  std::vector<Run> runs;
  int twists_of_origin = 0;  ///< of the twists between them, those before the belly's middle

  // By node.
  std::vector<double> along;  ///< m along the rest path
  std::vector<Vec3> offset;   ///< from the curve, in its frame
  std::vector<double>
      stretch_share;  ///< share of the belly's change of length before the node, 0..1
  std::vector<double> stretch_rate;  ///< its derivative, 1/m: 0 in the tendons
  std::vector<double> bulge;         ///< b w(u): how much of the belly's swelling the node takes
  std::vector<double> inner;         ///< 1 in the belly, falling to 0 at its ends
  /// A soft body without a path: the body that holds each node, -1 none; `offset` is the node's
  /// place in that body, or in the world. Empty for a muscle.
  std::vector<int> held;
};

/// What the carried shape is at one pose.
struct CarriedPose {
  CarryCurve curve;
  double path_length = 0.0;  ///< m, musculotendon, exact
  double change = 0.0;       ///< m, by which the path is longer than at rest
  Pose bodies;               ///< without a path
};

/// By node, the axis coordinate along the belly, 0..1 and clamped in the tendons, where a profile
/// of weights is given. `belly` in m along the rest path.
std::vector<double> belly_coordinates(const TriMesh& mesh, const MusclePath& path,
                                      const Pose& rest_pose, const std::array<double, 2>& belly,
                                      const Lengths& lengths = {});

/// `belly` and `twist_from` in m along the rest path. `weights`, by node, in any unit, say how much
/// of the belly's swelling each node takes; they are scaled so that the carried shape keeps its
/// volume.
CarriedShape make_carried_shape(const TriMesh& mesh, const MusclePath& path, const Pose& rest_pose,
                                const std::array<double, 2>& belly,
                                const std::vector<double>& weights, double twist_from = 0.0,
                                const Lengths& lengths = {});

/// Without a path: nodes go with the bodies that hold them, the others have their rest place.
CarriedShape make_held_shape(const TriMesh& mesh, const std::vector<int>& held,
                             const Pose& rest_pose);

CarriedPose carry_pose(const CarriedShape& shape, const Pose& pose);
/// What it works with: nothing goes from call to call but memory, so that a step does not allocate.
struct CarryWork {
  TracedPath traced;
  std::vector<Vec3> even, points;  ///< at equal distances, with the corners and without, m
  CurveFrames frames;
  std::vector<FrameBody> bodies;
  std::vector<double> scratch, twists;  ///< rad, between the bodies
};
void carry_pose(const CarriedShape& shape, const Pose& pose, CarryWork& work, CarriedPose& out);

/// Local stretch of the belly at a node, 1 in the tendons.
double stretch_at(const CarriedShape& shape, const CarriedPose& pose, int node);

/// The carried shape itself (g^2 = 1 + b w (1/s - 1), see this folder's README), one row per node;
/// with `swell` false offsets keep their size. `scaled`, where asked for: the same of a muscle with
/// a path, its offsets in the belly scaled by `scale` besides.
void carried_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                       Points& positions, double scale = 1.0, Points* scaled = nullptr);

/// What a muscle was measured to differ from its carried shape by, in the curve's frames: by knot,
/// knots by rising change of the path. Linear between knots, constant beyond them.
struct CarriedProfile {
  std::vector<double> change;             ///< m
  std::vector<std::vector<Vec3>> offset;  ///< [knot][node], m
};
/// The offsets of one knot, from nodes at x.
std::vector<Vec3> profile_offsets(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                                  const Points& x);
/// The carried shape with its profile (one knot at least) upon it. Not for held shapes.
void profiled_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                        const CarriedProfile& profile, Points& positions);

/// The same of one node of a shape.
double belly_coordinate(const CarriedShape& shape, int node);

/// u along the path 0..1, angle about it (rad), 1 in the belly to 0 in the tendons: for drawing
/// fibres.
std::array<double, 3> fibre_coordinates(const CarriedShape& shape, int node);

/// Point and tangent of the curve at `along` m of the rest path.
void curve_at(const CarriedShape& shape, const CarriedPose& pose, double along, Vec3& point,
              Vec3& tangent);

}  // namespace thew::muscles
