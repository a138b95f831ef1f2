// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/surface/surface.h"

namespace thew::skin {

/// A rigid bone, in the frame of its body.
struct RigidBone {
  int body = -1;
  Surface surface;
  Points x;  ///< m
  Bvh bvh;
  NodeBox box;
};
RigidBone rigid_bone(int body, Surface surface, Points x);

inline constexpr double kAny = 1e3;         ///< m, beyond all that is searched
inline constexpr double kOnSurface = 1e-9;  ///< m

/// The nearest point of the bone to p within `within` (m), or, if p may be inside, in any distance.
/// p is known to be no nearer to its surface than `at_least`, and no farther if inside than
/// `at_most` (m).
ClosestPoint nearest_on(const RigidBone& bone, const Vec3& p, double within, double at_least = 0.0,
                        double at_most = kAny);
/// Unit vector from the bone to p.
Vec3 away_from(const ClosestPoint& nearest, const Vec3& p);

}  // namespace thew::skin
