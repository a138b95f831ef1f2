// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
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
/// The traced path with rounded corners, sampled at equal distances, with a frame at each sample.
/// Rounding makes it a little shorter than the path, so a position on it is given as a share of its
/// length, which stands for the same share of the path. From sample to sample the frame turns as
/// little as possible; the twist that is left over at the insertion (see share_twist) is
/// distributed evenly beyond `twist_from`. Where the path turns back on itself, or leaves a bone at
/// more than 115 degrees from its direction at rest, that smallest rotation changes abruptly with
/// the pose. There the bodies along the path give the frames instead (see carried_normal).
struct CarryCurve {
  std::vector<CurveSample, AlignedAllocator<CurveSample>> samples;
};

/// The constant data by which the rest shape of a muscle is carried along its path in a pose.
/// Tendons are rigid: the belly, from `belly[0]` to `belly[1]`, takes all the change of length, and
/// swells as it shortens.
struct CarriedShape {
  MusclePath path;
  std::array<double, 2> belly = {0.0, 0.0};  ///< m along the rest path
  double twist_from = 0.0;                   ///< m along the rest path
  double rest_path_length = 0.0;             ///< m, of the exact path
  Lengths lengths;
  /// Frames of the ends of the curve, in the frames of their bodies.
  std::array<Mat3, 2> rest_end_frames;
  CurveFrames rest;  ///< frames of the curve at rest, by sample
  /// Successive points of the path that one body carries.
  struct Run {
    int first, last;
    Mat3 rest_rotation;  ///< rotation of the body in the rest pose
    Vec3 along;  ///< unit vector in the rest pose: from the middle between this run and the one
                 ///< before to the farther end of the path
  };
  std::vector<Run> runs;
  /// Number of twists between runs that lie before the middle of the belly.
  int twists_of_origin = 0;

  // By node.
  std::vector<double> along;  ///< m along the rest path
  std::vector<Vec3> offset;   ///< from the curve, in its frame
  /// Share of the change of length that lies before the node, 0..1.
  std::vector<double> stretch_share;
  /// Derivative of stretch_share along the rest path, 1/m; 0 in the tendons.
  std::vector<double> stretch_rate;
  /// b w: how much of the swelling of the belly the node takes, see carried_positions.
  std::vector<double> bulge;
  std::vector<double> inner;  ///< 1 in the belly, falling to 0 at its ends
  /// For a soft body without a path: the body to which each node is fixed, -1 if none. `offset` is
  /// then the position of the node in the frame of that body, or in the world. Empty for a muscle
  /// with a path.
  std::vector<int> fixed_to;
  /// If set, moves the points of the curve (m) out of the way of bones in a pose in which the path
  /// has a length (m); whether it did. What it keeps in the scratch memory spares it searches and
  /// does not change the result.
  std::function<bool(const Pose&, double, std::vector<Vec3>&, std::vector<Points>&)> give_way = {};
  /// If set, moves carried nodes (m) out of bones in a pose; the scratch memory as above.
  std::function<void(const Pose&, Points&, std::vector<Points>&)> clear_bones = {};
};

/// The carried shape in one pose.
struct CarriedPose {
  CarryCurve curve;
  double path_length = 0.0;  ///< m, of tendons and belly, exact (see TracedPath)
  double change = 0.0;       ///< m, path length less its rest length
  Pose bodies;               ///< for a body without a path
};

/// For each node of `mesh` its coordinate along the belly, 0 at `belly[0]` and 1 at `belly[1]` (m
/// along the rest path), clamped to 0..1 in the tendons. Profiles of weights are functions of it.
std::vector<double> belly_coordinates(const TriMesh& mesh, const MusclePath& path,
                                      const Pose& rest_pose, const std::array<double, 2>& belly,
                                      const Lengths& lengths = {});

/// Builds the carried shape of a muscle whose mesh is given in `rest_pose`. `belly` and
/// `twist_from` are in m along the rest path. `weights`, one for each node and in any unit, tell
/// how much of the swelling of the belly each node takes; they are scaled so that the carried shape
/// keeps its volume.
CarriedShape make_carried_shape(const TriMesh& mesh, const MusclePath& path, const Pose& rest_pose,
                                const std::array<double, 2>& belly,
                                const std::vector<double>& weights, double twist_from = 0.0,
                                const Lengths& lengths = {});

/// The same for a body without a path: nodes move with the bodies that they are fixed to
/// (`fixed_to`, -1 for none), the others keep their rest position.
CarriedShape make_fixed_shape(const TriMesh& mesh, const std::vector<int>& fixed_to,
                              const Pose& rest_pose);

CarriedPose carry_pose(const CarriedShape& shape, const Pose& pose);
/// Scratch memory of carry_pose, kept so that a step does not allocate; its contents do not matter.
struct CarryWork {
  TracedPath traced;
  /// m, at equal distances along the path, with sharp and with rounded corners.
  std::vector<Vec3> even, points;
  CurveFrames frames;
  std::vector<FrameBody> bodies;
  std::vector<double> scratch, twists;  ///< twists in rad, between successive bodies
  std::vector<Points> around, cleared;  ///< of give_way, and of clear_bones
};
void carry_pose(const CarriedShape& shape, const Pose& pose, CarryWork& work, CarriedPose& out);

/// Local stretch s of the belly at a node [1]: 1 in the tendons, at least 0.2.
double stretch_at(const CarriedShape& shape, const CarriedPose& pose, int node);

/// Positions (m) of the nodes on the carried shape. Offsets from the curve are multiplied by g, g^2
/// = 1 + b w (1/s - 1) (sim/method.md, "The carried shape"), or keep their length if `swell` is
/// false. If `scaled` is given, it gets the same with the offsets in the belly multiplied by
/// `scale` as well; only for a muscle with a path.
void carried_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                       Points& positions, double scale = 1.0, Points* scaled = nullptr);

/// By how much the nodes of a muscle were measured to differ from its carried shape, in the frames
/// of the curve, for some changes of the path length (knots, rising). Linear between knots,
/// constant beyond them.
struct CarriedProfile {
  std::vector<double> change;             ///< m
  std::vector<std::vector<Vec3>> offset;  ///< [knot][node], m
};
/// The offsets of one knot, measured from nodes at x.
std::vector<Vec3> profile_offsets(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                                  const Points& x);
/// Positions (m) of the carried shape with the offsets of a profile of at least one knot added.
/// Only for a muscle with a path.
void profiled_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                        const CarriedProfile& profile, Points& positions);

/// Coordinate of a node along the belly, see belly_coordinates.
double belly_coordinate(const CarriedShape& shape, int node);

/// Coordinates for drawing fibres: share of the path before the node (0..1), angle about the path
/// (rad), and a fade from 1 in the belly to 0 in the tendons.
std::array<double, 3> fibre_coordinates(const CarriedShape& shape, int node);

/// Point (m) and unit tangent of the curve in the pose, at the position that is `along` m along the
/// rest path.
void curve_at(const CarriedShape& shape, const CarriedPose& pose, double along, Vec3& point,
              Vec3& tangent);

}  // namespace thew::muscles
