// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rig/types.h"

namespace thew::rig {

// What a number of a file may be, so that no arithmetic on it ends in what is no number.

/// m: no place is farther from the origin along an axis, and nothing longer. float32, in which
/// bakes and most formats hold places, parts them by a millimetre there.
inline constexpr double kFarthest = 1e4;
/// rad: sin_cos() is exact within it.
inline constexpr double kMostTurn = 1e4;
/// Micrometres to metres, and back: what a unit may be.
inline constexpr double kLeastScale = 1e-6, kMostScale = 1e6;

/// Whether it is a place: false for what is no number as well.
bool is_place(const Vec3& p, double farthest = kFarthest);
/// Error(kInput), "WHERE lies at ..., farther than 10 km; NEXT", unless it is one.
void check_place(const Vec3& p, const std::string& where, const std::string& next);

}  // namespace thew::rig
