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

// What a muscle's solver works with inside a step. Nothing here goes from step to step but memory,
// so that a step does not allocate, and the factor of a matrix that is still the same.

/// Of the volume's multiplier, whatever the integrator.
struct VolumeWork {
  Points gradient;                      ///< dV/dx, m^2
  Points direction;                     ///< along which the volume is restored
  std::vector<double> zone_targets;     ///< m^3, see zone_targets()
  std::vector<Points> zone_directions;  ///< by cut, then the whole's
  ZoneScratch zones;
  ZoneWork deformation_zone;
};

struct LocalGlobalWork {
  Points base;          ///< what of the right-hand side stays the same in a step, N
  Points forces;        ///< N
  Points weighted;      ///< W dV/dx, m^2
  Points even, unused;  ///< the direction of even weights
  Points apart;         ///< by contact: the node from its point when the step began (friction), m
  PointPairs pairs;
  RingSprings::BySlot rest_by_slot;  ///< of the rings, now
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
  double frame = 0.0;                ///< s, of all substeps
  int substeps = 0;                  ///< of a frame that is so long
  Points forces;                     ///< N
  std::vector<double> inverse_mass;  ///< 1/kg
  std::vector<double> mobility;      ///< weight over mass, 1/kg
  Points predicted, drag;            ///< m; m/s
  Points target;                     ///< within the frame, m
  std::vector<double> rest_length;   ///< the same
  RingSprings::BySlot rest_by_slot;  ///< the same, of the rings
  ContactPlanes touches;
  NearPlanes near;
};

/// Of the integrator in use alone.
using IntegratorWork = std::variant<std::monostate, LocalGlobalWork, XpbdWork, ExplicitWork>;
template <typename Work>
Work& work_of(IntegratorWork& work) {
  if (!std::holds_alternative<Work>(work)) work.emplace<Work>();
  return std::get<Work>(work);
}

}  // namespace thew::sim
