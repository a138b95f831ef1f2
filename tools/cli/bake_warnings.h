// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/bake/bake.h"

namespace thew::tools {

/// A line for each joint between two bones of a character that its motion moves from where it is at
/// rest, by 5 mm or 2 % of the bone above: with the bone, the farthest frame and millimetres.
std::vector<std::string> joints_out_of_place(const Model& model, const std::vector<int>& frames);

/// The model's, and after them what the bake found; `reader` is of its complete cache.
std::vector<std::string> bake_warnings(const Model& model, const std::vector<int>& frames,
                                       const BakeResult& result, const BakeReader& reader);

/// That a skin that is to keep its volume could not, how far it is off and where; else empty.
std::string skin_too_full(const Model& model, const std::vector<int>& frames,
                          const std::vector<FrameMeasures>& measures);

}  // namespace thew::tools
