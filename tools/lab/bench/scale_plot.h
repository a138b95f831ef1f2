// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace thew::tools {

struct ScalePoint {
  int copies = 1;
  double milliseconds = 0.0, expected = 0.0;  ///< a frame: measured, and by n log n from the first
};
/// Both logarithmic; carries its own style.
std::string draw_scale(const std::string& title, const std::vector<ScalePoint>& points);

}  // namespace thew::tools
