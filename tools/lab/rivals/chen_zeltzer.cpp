// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/chen_zeltzer.h"

#include <Eigen/LU>

namespace thew::tools {

double hill_force_length(double stretch) {
  const double off = 2.0 * (stretch - 1.0);
  return std::max(1.0 - off * off, 0.0);
}

void add_fibre_forces(const HillFibres& fibres, const FemBody& body, Eigen::VectorXd& f) {
  for (int e = 0; e < body.count(); ++e) {
    const int* const node = body.elements.data() + 4 * e;
    Mat3 now, rest;
    for (int k = 0; k < 3; ++k) {
      now.col(k) = body.x[node[k + 1]] - body.x[node[0]];
      rest.col(k) = body.rest[node[k + 1]] - body.rest[node[0]];
    }
    const Mat3 inverse = rest.inverse();
    const Vec3 fibre = now * inverse.col(0);  // F e_x
    const double stretch = fibre.norm();
    if (!(stretch > 0.0)) continue;
    // P = stress F a a^T / stretch, f = -V0 P grad N
    const Vec3 pull = -body.rest_volume[e] * fibres.stress * fibres.activation *
                      hill_force_length(stretch) / stretch * fibre;
    Vec3 left = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vec3 part = inverse(k, 0) * pull;
      f.segment<3>(3 * node[k + 1]) += part;
      left += part;
    }
    f.segment<3>(3 * node[0]) -= left;
  }
}

Stepper chen_zeltzer_stepper(const RivalBody& body, const FemMaterial& material, double drag,
                             const HillFibres& fibres) {
  return warped_stepper(body, material, drag, false, [fibres](const FemBody& fem, auto& f) {
    add_fibre_forces(fibres, fem, f);
  });
}

}  // namespace thew::tools
