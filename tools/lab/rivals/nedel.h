// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "tools/lab/rivals/springs_step.h"

namespace thew::tools {

/// Nedel, Thalmann, Real time muscle deformations using mass-spring systems (Computer Graphics
/// International 1998): linear springs along the edges of a muscle's surface, and at its nodes
/// angular springs, which ask for the angle at rest between an edge and the one opposite it in the
/// node's ring. Nothing else is there to control the volume.
struct AngularSpring {
  int at, a, b;  ///< nodes: the angle is at `at`
  double rest;   ///< rad
};
std::vector<AngularSpring> angular_springs(const RivalBody& body);
/// f += -dE/dx, E = stiffness (angle - rest)^2 / 2, N m a spring.
void add_angular_forces(const std::vector<AngularSpring>& springs, double stiffness,
                        const Points& x, Points& f);
Stepper nedel_stepper(const RivalBody& body, double drag, double stiffness);

}  // namespace thew::tools
