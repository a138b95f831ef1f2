// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/multiplier.h"

namespace thew::tools {

Stepper multiplier_stepper(const RivalBody& body, double drag) {
  return corrected_stepper(body, drag, true, true);
}

}  // namespace thew::tools
