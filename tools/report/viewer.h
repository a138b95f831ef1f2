// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/cache/cache.h"

namespace thew::tools {

/// A bake as a piece of a page: WebGL 2, no network. To orbit and play, with layers that are
/// switched on and off, coloured by muscle, weight or volume error. Positions are rounded to 16
/// bits of the bake's extent and long bakes are thinned out; the page states both.
std::string report_viewer(const BakeReader& bake);

}  // namespace thew::tools
