// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace thew::tests {

/// Of how many frames or poses a test asks one: `by_default`, and all under `tools/check --long`,
/// which sets THEW_EVERY=1.
inline int every(int by_default) {
  const char* asked = std::getenv("THEW_EVERY");
  return asked ? std::atoi(asked) : by_default;
}

}  // namespace thew::tests
