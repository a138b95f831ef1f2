// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/elements/fem.h"
#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// A filled body as linear tetrahedra of fem.h.
FemBody elements_of(const RivalBody& body, const FemMaterial& material);

/// Implicit Euler on such elements, Newton to `iterations` steps at most:
///  - linear elasticity with a volume penalty, as the paper has it;
///  - stable neo-Hookean (Smith, de Goes, Kim, Stable neo-Hookean flesh simulation, 2018).
struct ElementSetting {
  FemMaterial material;
  double drag = 2.0;  ///< 1/s
  int iterations = 8;
  bool direct = false;
};
Stepper element_stepper(const RivalBody& body, const ElementSetting& setting);

constexpr double kFirmness = 1e4;  ///< N/m of obstacles at a node, of all implicit methods

}  // namespace thew::tools
