// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/springs_step.h"

namespace thew::tools {

/// Promayon, Baconnier, Puech, Physically-based deformations constrained in displacements and
/// volume (Eurographics 1996), and A physically-based model for simulating the human trunk
/// respiration movements (CVRMed 1997). A free step, then all nodes go along the volume's gradient
/// at one scale s: V(x + s dV/dx) = V0, a cubic in s, whatever their masses. `reaction`: the way is
/// added to the velocities, as of a force of reaction; without it they do not know of the
/// constraint. Nodes that an obstacle stops go along it only.
Stepper promayon_stepper(const RivalBody& body, double drag, bool reaction);

}  // namespace thew::tools
