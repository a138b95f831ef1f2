// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/springs_step.h"

namespace thew::tools {

/// Hong, Jung, Choi, Welch, Fast volume preservation for a mass-spring system (2006), as Thew mends
/// it, on the footing of the others: the same springs, step and obstacles. The multiplier's
/// direction is dV/dx over mass, its size the cubic's root, and the velocities have it too.
Stepper multiplier_stepper(const RivalBody& body, double drag);

}  // namespace thew::tools
