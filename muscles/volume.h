// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/types.h"

namespace thew::muscles {

/// Volume (m^3) enclosed by a closed surface (paper, eq. 1), with positions relative to the
/// centroid of the nodes, because the sum loses digits far from the origin.
double enclosed_volume(const Points& x, const std::vector<Triangle>& triangles);

/// Sets `gradient` to dV/dx (m^2), one row for each node: the gradient of the paper's sidebar A,
/// which is printed multiplied by -3.
void volume_gradient(const Points& x, const std::vector<Triangle>& triangles, Points& gradient);

/// V(x + s d) = c0 + c1 s + c2 s^2 + c3 s^3 (m^3), exactly, in one pass over the triangles.
struct VolumeCubic {
  double c0, c1, c2, c3;
};
VolumeCubic volume_along(const Points& x, const Points& d, const std::vector<Triangle>& triangles);

/// The real root s nearest to zero of V(x + s d) = target (m^3), found between 0 and the nearest
/// extremum to rounding error. `reached` is false if V does not reach the target there; s is then
/// the extremum (0 if the gradient vanishes or a coefficient is not finite).
struct VolumeRoot {
  double s = 0.0;
  bool reached = true;
};
VolumeRoot nearest_root(const VolumeCubic& cubic, double target);

}  // namespace thew::muscles
