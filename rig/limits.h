// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rig/types.h"

namespace thew::rig {

// Bounds on the numbers of a file, so that arithmetic on them neither overflows nor yields NaN.

/// m, bound of each coordinate of a position and of each length. At 10 km the float32 numbers in
/// which bakes and most formats store positions are still 1 mm apart.
inline constexpr double kMaxCoordinate = 1e4;
/// rad, bound of an angle; the error bound of sin_cos() holds up to 1e5.
inline constexpr double kMaxAngle = 1e4;
/// Bounds of a scale, which converts a unit to metres: from micrometres to 1,000 km.
inline constexpr double kMinScale = 1e-6, kMaxScale = 1e6;

/// Whether each component lies within +-`limit`; false for NaN.
bool is_bounded(const Vec3& p, double limit = kMaxCoordinate);
/// Throws Error(kInput), "WHERE lies at ..., farther than 10 km; NEXT", if a coordinate of p is
/// beyond kMaxCoordinate or NaN.
void check_position(const Vec3& p, const std::string& where, const std::string& next);

}  // namespace thew::rig
