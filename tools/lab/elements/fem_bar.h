// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/mesh.h"
#include "tools/lab/elements/fem.h"

namespace thew::tools {

/// The spindle of `assets/paper/bar.toml`: an ellipsoid along x that is held beyond |x| = `held`,
/// and whose half x < 0 two plates squeeze.
struct BarShape {
  Vec3 half = Vec3(0.2, 0.05, 0.05);       ///< m, its half axes
  double neck = 0.0;                       ///< how much thinner it is in its middle, 0..1
  double held = 0.18;                      ///< m
  double travel = 0.025, rounding = 0.02;  ///< m: of each plate, and of its edge at x = 0
};

constexpr double kNeck = 0.8;  ///< of the one with two bellies

/// Its thickness over the ellipsoid's at x = u half.x.
double bar_thinning(double neck, double u);

/// A quarter of it (y, z >= 0) between the tips: 3 n^2 m quadratic tetrahedra, m along x, its ends
/// and planes of symmetry fixed. Neo-Hookean.
FemBody quarter_bar(const BarShape& shape, int n, int m, const FemMaterial& material);

/// Brings the plates together quasi-statically in `steps`. The result of the last that converged.
FemResult squeeze_bar(const BarShape& shape, int steps, FemBody& body);

}  // namespace thew::tools
