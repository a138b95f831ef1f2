// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/elements.h"

namespace thew::tools {

/// Chen, Liu, Yang, Yuksel, Vertex block descent (SIGGRAPH 2024): implicit Euler's energy, node
/// after node each by one Newton step of its own 3 x 3 system, the others held; here on stable
/// neo-Hookean tetrahedra (Smith, de Goes, Kim 2018), from the guess by inertia.
struct DescentBody {
  FemMaterial material;
  std::vector<Tetrahedron> tetrahedra;
  std::vector<Mat3> rest_inverse;                   ///< by tetrahedron
  std::vector<double> rest_volume;                  ///< m^3
  std::vector<std::vector<std::array<int, 2>>> at;  ///< by node: (tetrahedron, corner)
};
DescentBody descent_body(const RivalBody& body, const FemMaterial& material);

/// J: sum of m |x - guess|^2 / (2 h^2), drag and the elements.
double descent_energy(const DescentBody& body, const RivalBody& now, const Points& start,
                      const Points& guess, double h, double drag);
Stepper descent_stepper(const RivalBody& body, const FemMaterial& material, double drag,
                        int iterations);

/// One pass over all nodes; `beyond` may be empty.
struct DescentPass {
  const DescentBody& body;
  const std::function<Vec3(const Vec3&)>& beyond;
  const Points &start, &guess;
  double h, drag;
};
void descend(const DescentPass& pass, RivalBody& now);

}  // namespace thew::tools
