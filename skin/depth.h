// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/contact/collider.h"

namespace thew::skin {

/// Whether p lies inside. Rays along the axes count how often they leave the surface less how often
/// they enter it: of a closed surface all find the same, however it is folded, and the sign of no
/// normal is asked. Of one with a hole five of six have to agree, or the winding number decides.
bool encloses(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p);

/// m, how far below the surface the deepest of those points lies that are inside it; 0: none is.
double deepest_inside(const Surface& surface, const Bvh& bvh, const Points& x,
                      const Points& points);
/// The same inside any of several.
double deepest_inside(const std::vector<Collider>& bodies, const Points& points);
/// m, how far from the surface the farthest of those points lies that are outside it.
double farthest_outside(const Surface& surface, const Bvh& bvh, const Points& x,
                        const Points& points);

}  // namespace thew::skin
