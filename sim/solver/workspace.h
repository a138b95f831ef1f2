// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <variant>
#include <vector>

#include "muscles/ring_springs.h"
#include "muscles/skyline.h"
#include "muscles/volume_zones.h"
#include "muscles/zone.h"
#include "skin/contact/explicit_contact.h"

namespace thew::sim {

// Scratch of a muscle's solver inside a step. From step to step it keeps allocated memory, so that
// a step does not allocate, and the factor of the matrix as long as the matrix is the same. Arrays
// have one row a node where nothing else is said.

/// For the volume's multiplier, in all integrators.
struct VolumeWork {
  Points gradient;                      ///< dV/dx, m^2
  Points direction;                     ///< d or z: along which the volume is restored
  std::vector<double> zone_targets;     ///< m^3, see zone_targets()
  std::vector<Points> zone_directions;  ///< by cut, then the whole's
  ZoneScratch zones;
  ZoneWork deformation_zone;
};

struct LocalGlobalWork {
  Points base;          ///< the part of the right-hand side that is constant in a step, N
  Points forces;        ///< N
  Points weighted;      ///< W dV/dx, m^2
  Points even, unused;  ///< the direction under even weights; scratch
  Points start_offset;  ///< [contact] m, the node relative to its point when the step began;
                        ///< friction only
  PointPairs pairs;
  RingSprings::BySlot rest_by_slot;  ///< m, rest lengths now
  SkylineFactor factor;
  std::vector<double> diagonal, factored_diagonal;  ///< added to the springs' matrix, N/m
};

struct XpbdWork {
  double step = 0.0;                      ///< s
  std::vector<double> inverse_mass;       ///< 1/kg, 0 where driven
  std::vector<double> length_multiplier;  ///< by spring, N s^2
  Points shape_multiplier;                ///< by spring, N s^2
  double volume_multiplier = 0.0;         ///< Pa s^2
};

struct ExplicitWork {
  double frame = 0.0;                ///< s, the step that the substeps divide
  int substeps = 0;                  ///< that a step of that length needs
  Points forces;                     ///< N
  std::vector<double> inverse_mass;  ///< 1/kg
  std::vector<double> mobility;      ///< weight over mass, 1/kg
  Points predicted, drag;            ///< m; m/s
  Points target;                     ///< m, within the step
  std::vector<double> rest_length;   ///< m, within the step
  RingSprings::BySlot rest_by_slot;  ///< m, the same in the order of the rings
  ContactPlanes touches;
  NearPlanes near;
};

/// Only that of the integrator in use is there.
using IntegratorWork = std::variant<std::monostate, LocalGlobalWork, XpbdWork, ExplicitWork>;
template <typename Work>
Work& work_of(IntegratorWork& work) {
  if (!std::holds_alternative<Work>(work)) work.emplace<Work>();
  return std::get<Work>(work);
}

}  // namespace thew::sim
