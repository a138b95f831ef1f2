// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/ring_springs.h"
#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// The springs that methods of a surface alone have in common, which are Thew's own, computed by
/// Thew's own kernel: what is compared is what holds the volume.
struct SurfaceSprings {
  SpringMaterial material = {.stiffness = 1000.0, .anisotropy = 1.0, .shear = 0.5};
  double dashpot = 1e-4;  ///< s, damping of a spring over its stiffness
  double drag = 2.0;      ///< 1/s
  RingSprings rings;      ///< from prepare_springs()
  RingSprings::BySlot rest_length;
};
/// `opposite`: those between the vertices opposite each edge too, else edges alone.
SurfaceSprings prepare_springs(const RivalBody& body, double drag, bool opposite = true);

/// The springs' forces (N), and dV/dx (m^2) where asked.
void spring_forces(const SurfaceSprings& springs, const RivalBody& body, Points& f,
                   Points* gradient);

/// v += h (f / m - drag v), x += h v; driven nodes with the surroundings, then out of obstacles.
void free_step(const Surroundings& around, double time, double h, double drag, const Points& f,
               RivalBody& body);

/// Sets `direction` to `mobility` dV/dx at free nodes (mobility: 1 over mass where `by_mass`, else
/// 1), along what obstacles leave free, and returns the s with V(x + s direction) = rest.
double volume_correction(const Surroundings& around, double time, double rest, bool by_mass,
                         const RivalBody& body, Points& direction);

/// The springs' free step, then s times the direction of volume_correction(); `reaction`: added to
/// the velocities too.
Stepper corrected_stepper(const RivalBody& body, double drag, bool by_mass, bool reaction);

}  // namespace thew::tools
