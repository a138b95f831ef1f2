// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/types.h"

namespace thew::tools {

/// Sign of det(b - a, c - a, d - a): 1, 0 or -1, exact for any coordinates whose triple products
/// neither overflow nor underflow (1e-80 to 1e80).
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Whether two triangles have a common point, touching and coplanar ones included. A triangle
/// without area counts as its edges, and meets no other without area.
using Corners = std::array<Vec3, 3>;
bool triangles_meet(const Corners& s, const Corners& t);

}  // namespace thew::tools
