// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/contact/collider.h"

namespace thew::skin {

/// Whether p lies inside a surface. Each ray from p along an axis counts how often it leaves the
/// surface less how often it enters it. For a closed surface all rays give the same count, however
/// it is folded, and no normal is needed. For a surface with holes five of six rays have to agree;
/// else the winding number decides.
bool encloses(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p);
/// How often a ray from p along x leaves the surface, less how often it enters it.
int ray_count(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p);

/// Largest distance (m) from the surface of the points that lie inside it; 0 if none does.
double deepest_inside(const Surface& surface, const Bvh& bvh, const Points& x,
                      const Points& points);
/// The same for several bodies: the largest of their results.
double deepest_inside(const std::vector<Collider>& bodies, const Points& points);
/// Largest distance (m) from the surface of the points that lie outside it; 0 if none does.
double farthest_outside(const Surface& surface, const Bvh& bvh, const Points& x,
                        const Points& points);

}  // namespace thew::skin
