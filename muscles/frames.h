// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/types.h"

namespace thew::muscles {

/// Points at equal distances along a polyline, both ends included. `scratch` is any memory, here
/// and below.
void resample(const std::vector<Vec3>& points, int count, std::vector<double>& scratch,
              std::vector<Vec3>& out);
/// Rounds a polyline of equal pieces of `spacing`, about as an arc of `radius` (m) would.
void round_corners(double spacing, double radius, std::vector<double>& scratch,
                   std::vector<Vec3>& p);

/// Frames along a curve, each turned from the one before by as little as its tangent asks for.
struct CurveFrames {
  std::vector<Vec3> tangent, normal;
};
/// The direction of the curve at point i, unit.
Vec3 tangent_at(const std::vector<Vec3>& points, int i);
/// `first` is the frame at the first point: tangent, normal, binormal.
void transport_frames(const std::vector<Vec3>& points, const Mat3& first, CurveFrames& frames);
/// The smallest turn that brings the frame's first column to `tangent`, applied to it.
Mat3 fitted_frame(const Mat3& frame, const Vec3& tangent);
/// The angle (rad) of `turn` about the unit vector `axis`, the turn taken as this and then the
/// least one that brings the axis to where it goes.
double turn_about(const Vec3& axis, const Mat3& turn);

/// How a curve's frames turn about it, in rad: as a whole, and by how much more in the share that
/// goes from one end to the other, beside transport and where frames are those of bodies.
struct Twist {
  double at_origin = 0.0, shared = 0.0, shared_of_bodies = 0.0;
  double doubt = 0.0;  ///< by how much the transported frames' twist differs from the bodies'
};
/// From the twists between bodies that follow one another along the path, and the angle at the
/// insertion between the transported frame and the one wanted: this tells the sum of the twists
/// exactly, but not how many times it goes round, which each of theirs within 180 degrees does.
/// Where one nears 180 degrees a tendon gives way: beyond 135 it lets go of a part, at 180 of all,
/// so that either sign is the same. The origin's gives way for the first `of_origin` twists, the
/// insertion's for the others.
Twist share_twist(const std::vector<double>& twists, double at_insertion, int of_origin);

/// A body that carries a part of the curve: how it has turned since rest, by how much it is twisted
/// against the first (rad), and the samples between which its points lie.
struct FrameBody {
  Mat3 turn;
  double twist = 0.0, first = 0.0, last = 0.0;
};
/// Unit, across the tangent t of sample i: where the bodies carry its normal at rest, each turned
/// by `angle` less its twist. Smooth where one of them points its tangent backwards: there that one
/// counts for nothing.
Vec3 carried_normal(const std::vector<FrameBody>& bodies, const CurveFrames& rest, int i,
                    const Vec3& t, double angle);

}  // namespace thew::muscles
