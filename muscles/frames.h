// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"
#include "rig/types.h"

namespace thew::muscles {

/// `count` points at equal distances along a polyline, both ends included. `scratch` is memory that
/// is overwritten, here and below.
void resample(const std::vector<Vec3>& points, int count, std::vector<double>& scratch,
              std::vector<Vec3>& out);
/// Rounds the corners of a polyline whose points are `spacing` (m) apart, about as an arc of
/// `radius` (m) would; the ends stay.
void round_corners(double spacing, double radius, std::vector<double>& scratch,
                   std::vector<Vec3>& p);

/// For each node of a mesh the share of the length of a polyline, of equal pieces, to which it
/// belongs: at which the line is nearest to it. Deep in a bend of the line that leaps between nodes
/// that are neighbours, and the two would be carried apart when the bend opens; there it is a mean
/// of the neighbours'.
std::vector<double> feet_along(const std::vector<Vec3>& line, const TriMesh& mesh);

/// Frames along a curve: unit tangents and unit normals, by point.
struct CurveFrames {
  std::vector<Vec3> tangent, normal;
};
/// Unit tangent of a polyline at point i, by central differences.
Vec3 tangent_at(const std::vector<Vec3>& points, int i);
/// Parallel transport: each frame is the one before, turned by the smallest rotation that brings
/// its tangent to that of the point. `first` is the frame at the first point, with columns tangent,
/// normal, binormal.
void transport_frames(const std::vector<Vec3>& points, const Mat3& first, CurveFrames& frames);
/// The frame, turned by the smallest rotation that brings its first column to `tangent`.
Mat3 fitted_frame(const Mat3& frame, const Vec3& tangent);
/// Angle (rad, in (-pi, pi]) of the part of a rotation about the unit vector `axis`: the rotation
/// is a twist about the axis, followed by the smallest rotation that moves the axis (swing-twist
/// decomposition).
double turn_about(const Vec3& axis, const Mat3& turn);

/// How the frames of a curve are turned about it, in rad, in addition to transport: all by
/// `at_origin`, and by a part of `shared` that grows from 0 to 1 along the curve. Where bodies give
/// the frames, `shared_of_bodies` takes the place of `shared`.
struct Twist {
  double at_origin = 0.0, shared = 0.0, shared_of_bodies = 0.0;
  /// How much the twist of the transported frames differs from that of the bodies.
  double doubt = 0.0;
};
/// Distributes the twist of a muscle. `twists` are those between successive bodies along the path,
/// each within 180 degrees. `at_insertion` is the angle at the insertion between the transported
/// frame and the one that the body asks for. That angle is exact but known only up to full turns;
/// the sum of the twists tells how many there are. As a twist nears 180 degrees a tendon lets go of
/// it: of nothing at 135 degrees, of all of it at 180, so that both signs of 180 degrees give the
/// same. The tendon of the origin does so for the first `of_origin` twists, that of the insertion
/// for the others.
Twist share_twist(const std::vector<double>& twists, double at_insertion, int of_origin);

/// A body that carries a part of the curve: its rotation since the rest pose, its twist against the
/// first body (rad), and the samples (fractional) of its first and last point.
struct FrameBody {
  Mat3 turn;
  double twist = 0.0, first = 0.0, last = 0.0;
};
/// The unit normal of sample i, across its tangent t, as the bodies carry it: a weighted mean of
/// the normal at rest, turned with each body and then about its tangent by `angle` less the twist
/// of that body. A body whose carried tangent points against t has weight 0, and its weight falls
/// to that smoothly.
Vec3 carried_normal(const std::vector<FrameBody>& bodies, const CurveFrames& rest, int i,
                    const Vec3& t, double angle);

}  // namespace thew::muscles
