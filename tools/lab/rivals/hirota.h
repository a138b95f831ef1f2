// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// Hirota, Maheshwari, Lin, Fast volume-preserving free-form deformation using multi-level
/// optimization (Solid Modeling 1999; Computer-Aided Design 2000). The surface lies in a lattice of
/// control points (trilinear cells); these minimise springs between neighbours of the lattice plus
/// a penalty on the volume, from one frame's optimum to the next. The optimiser is NLopt's L-BFGS.
/// Without inertia, so it has no step and no momentum.
struct LatticeSetting {
  int cells = 5;           ///< along each side
  double young = 3000.0;   ///< Pa, of the lattice's springs
  double modulus = 1e6;    ///< Pa, of the volume; 0: none
  int evaluations = 2000;  ///< of the energy, at most
};
struct Lattice {
  LatticeSetting setting;
  std::vector<Vec3> rest;
  struct Spring {
    int a, b;
    double stiffness, length;  ///< N/m, m
  };
  std::vector<Spring> springs;
  std::vector<std::array<int, 8>> corners;     ///< by node of the surface
  std::vector<std::array<double, 8>> weights;  ///< trilinear
};
Lattice make_lattice(const RivalBody& body, const LatticeSetting& setting);
/// Energy (J) of control points and its gradient; `x` gets the surface.
double lattice_energy(const Lattice& lattice, const RivalBody& body,
                      const std::function<Vec3(const Vec3&)>& beyond, const Points& driven,
                      const std::vector<double>& control, Points& x, std::vector<double>* gradient);
/// J, of the body stretched along its axes, nothing held.
double stretched_energy(const RivalBody& body, const LatticeSetting& setting, const Vec3& stretch);
Stepper hirota_stepper(const RivalBody& body, const LatticeSetting& setting);

}  // namespace thew::tools
