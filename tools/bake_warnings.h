// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/bake.h"

namespace thew {

/// The model's, and after them what the bake found; `reader` is of its complete cache.
std::vector<std::string> bake_warnings(const Model& model, const std::vector<int>& frames,
                                       const BakeResult& result, const BakeReader& reader);

}  // namespace thew
