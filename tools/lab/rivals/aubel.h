// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// Aubel, Thalmann, Interactive modeling of the human musculature (Computer Animation 2001): a
/// belly between tendons on an action line. What is held goes with its bone; between, each section
/// follows the line, and its two axes are scaled alike by sqrt(L0 / L), so that the volume of the
/// belly stays. The line is x.
double aubel_widening(double rest_length, double length);
Stepper aubel_stepper(const RivalBody& body);

}  // namespace thew::tools
