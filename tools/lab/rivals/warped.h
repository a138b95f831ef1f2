// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/elements.h"

namespace thew::tools {

/// Mueller, Gross, Interactive virtual materials (Graphics Interface 2004): linear elements whose
/// stiffness is turned with each element, f = -R K (R^T x - X), R the rotation of x's deformation;
/// implicit Euler with one linear system a step, by conjugate gradients.
struct WarpedForces {
  Eigen::VectorXd f;              ///< N, by coordinate
  Eigen::SparseMatrix<double> k;  ///< sum of R K R^T, N/m
};
/// `turned` false: R = 1, linear elasticity.
void warped_forces(FemBody& body, bool turned, WarpedForces& out);
/// `active`, where given: forces (N) besides, and nothing of their own stiffness.
using ActiveForces = std::function<void(const FemBody&, Eigen::VectorXd& f)>;
Stepper warped_stepper(const RivalBody& body, const FemMaterial& material, double drag,
                       bool turned = true, const ActiveForces& active = {});

}  // namespace thew::tools
