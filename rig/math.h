// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/types.h"

namespace thew::rig {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;

/// Sine and cosine with the same bytes on every processor; those of glibc differ between
/// processors. Absolute error below 2e-16 for |angle| < 1e5 rad; NaN for an angle that is not
/// finite.
struct SinCos {
  double sin, cos;
};
SinCos sin_cos(double angle);

/// atan2 with the same bytes on every processor. The result lies in (-pi, pi] rad, with an error
/// below 1e-15; it is NaN for NaN or infinite arguments.
double arc_tan2(double y, double x);

/// Rotation by `angle` (rad) about the unit vector `axis` (Rodrigues).
Mat3 rotation_about(const Vec3& axis, double angle);

/// The rotation by the smallest angle that takes unit vector `from` to unit vector `to`; the
/// identity where they are parallel or opposite.
Mat3 least_turn(const Vec3& from, const Vec3& to);

/// 0 for t <= a, 1 for t >= b, and 3 u^2 - 2 u^3 between, with u = (t - a) / (b - a).
double smoothstep(double a, double b, double t);

}  // namespace thew::rig
