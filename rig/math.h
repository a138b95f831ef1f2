// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/types.h"

namespace thew::rig {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;

/// Sine and cosine with the same bytes on every processor (glibc's differ by processor).
/// Error below 2e-16 relative to 1 for |angle| < 1e5 rad.
struct SinCos {
  double sin, cos;
};
SinCos sin_cos(double angle);

/// atan2 with the same bytes on every processor; result in (-pi, pi]. Error below 1e-15.
double arc_tan2(double y, double x);

/// Rotation by `angle` (rad) about the unit vector `axis` (Rodrigues).
Mat3 rotation_about(const Vec3& axis, double angle);

/// The least rotation that takes one unit vector to another.
Mat3 least_turn(const Vec3& from, const Vec3& to);

/// 0 below a, 1 above b, 3t^2 - 2t^3 between.
double smoothstep(double a, double b, double t);

}  // namespace thew::rig
