// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// Scheepers, Parent, Carlson, May, Anatomy-based modeling of the human musculature (SIGGRAPH
/// 1997): a fusiform belly is an ellipsoid of constant volume v and constant ratio r of its two
/// short half axes; its long half axis c follows the distance between its ends, so b = sqrt(3 v /
/// (4 pi r c)) and a = r b.
Vec3 scheepers_axes(double volume, double ratio, double c);  ///< m: a, b, c
/// The whole body along x, as such an ellipsoid between its driven ends.
Stepper scheepers_stepper(const RivalBody& body);

}  // namespace thew::tools
