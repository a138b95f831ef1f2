// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::tests {

/// m, the largest of all nodes of all muscles.
inline double worst_distance(const State& a, const State& b) {
  double worst = 0.0;
  for (int m = 0; m < a.count(); ++m) {
    worst = std::max(worst, largest_distance(a.muscles[m].x, b.muscles[m].x));
  }
  return worst;
}

}  // namespace thew::tests
