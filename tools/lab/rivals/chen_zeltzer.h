// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/warped.h"

namespace thew::tools {

/// Chen, Zeltzer, Pump it up: computer animation of a biomechanically based model of muscle using
/// the finite element method (SIGGRAPH 1992): linear elasticity, and forces along the fibres by
/// Hill's curve (Zajac 1989), which pull the nodes together. Fibres run along x.
struct HillFibres {
  double stress = 2e3;  ///< Pa at full activation and rest length
  double activation = 1.0;
};
/// Active stress over that at rest length, by stretch: 1 there, 0 at half and one and a half of it.
double hill_force_length(double stretch);
/// Adds the fibres' forces at body.x.
void add_fibre_forces(const HillFibres& fibres, const FemBody& body, Eigen::VectorXd& f);
Stepper chen_zeltzer_stepper(const RivalBody& body, const FemMaterial& material, double drag,
                             const HillFibres& fibres);

}  // namespace thew::tools
