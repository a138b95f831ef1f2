// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/types.h"

namespace thew::muscles {

/// Volume (m^3) enclosed by a closed surface; paper eq. 1, about the nodes' centroid.
double enclosed_volume(const Points& x, const std::vector<Triangle>& triangles);

/// dV/dx (m^2), one row per node; paper sidebar A, mended by -1/3. Overwrites `gradient`.
void volume_gradient(const Points& x, const std::vector<Triangle>& triangles, Points& gradient);

/// V(x + s d) = c0 + c1 s + c2 s^2 + c3 s^3, exactly, in one pass over the triangles.
struct VolumeCubic {
  double c0, c1, c2, c3;
};
VolumeCubic volume_along(const Points& x, const Points& d, const std::vector<Triangle>& triangles);

/// Real root s nearest zero of V(x + s d) = target, bracketed between 0 and the nearest extremum
/// and polished to rounding error. `reached` is false where no motion along d reaches the target;
/// s is then the extremum that comes nearest (0 for a vanishing gradient).
struct VolumeRoot {
  double s = 0.0;
  bool reached = true;
};
VolumeRoot nearest_root(const VolumeCubic& cubic, double target);

}  // namespace thew::muscles
