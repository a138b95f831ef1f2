// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/promayon.h"

namespace thew::tools {

Stepper promayon_stepper(const RivalBody& body, double drag, bool reaction) {
  return corrected_stepper(body, drag, false, reaction);
}

}  // namespace thew::tools
