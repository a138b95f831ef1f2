// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "tools/lab/rivals/springs_step.h"

namespace thew::tools {

/// Bourguignon, Cani, Controlling anisotropy in mass-spring systems (Computer Animation and
/// Simulation 2000): springs along the edges of tetrahedra, and for the volume of each a force at
/// its nodes from its barycentre B by how the sum of the distances has changed,
///   F_j = -k (sum_i |x_i - B| - sum_i |X_i - B|) (x_j - B) / |x_j - B|.
/// As printed its sum over the four nodes is not zero: B's own share is missing.
struct BarycentreSprings {
  double stiffness = 0.0;        ///< N/m
  std::vector<double> rest_sum;  ///< m, by tetrahedron
  bool balanced = false;         ///< with B's share, so that the forces of each cancel
};
BarycentreSprings barycentre_springs(const RivalBody& body, double stiffness);
void add_barycentre_forces(const BarycentreSprings& springs, const RivalBody& body, Points& f);

/// Edges of tetrahedra, k = young * (sum of their volumes) / length^2 (Van Gelder 1998).
Springs solid_springs(const RivalBody& body, double young);
Stepper bourguignon_stepper(const RivalBody& body, double drag, double young, double stiffness);

}  // namespace thew::tools
