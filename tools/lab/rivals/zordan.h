// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/springs_step.h"

namespace thew::tools {

/// Zordan, Celly, Chiu, DiLorenzo, Breathe easy: model and control of human respiration for
/// computer animation (SCA 2004; Graphical Models 2006). A pressure by how much volume is missing,
/// p = modulus (V0 - V) / V0, pushes each triangle along its normal: f = p dV/dx. `modulus` in Pa;
/// 0: a conventional mass-spring system.
Stepper zordan_stepper(const RivalBody& body, double drag, double modulus);

}  // namespace thew::tools
