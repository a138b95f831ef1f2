// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/carried_shape.h"

namespace thew::sim {

/// How a muscle is simulated, from the cheapest up.
enum class Level {
  kAsleep,       ///< nothing that drives it or may touch it moves: left alone
  kGeometric,    ///< its carried shape with a measured profile, at the exact volume: no forces
  kQuasiStatic,  ///< springs, contact and volume, without inertia
  kDynamic       ///< the same with inertia and damping
};

constexpr bool has_forces(Level level) { return level >= Level::kQuasiStatic; }

/// What a muscle gets where the scene gives a tolerance.
struct MuscleFidelity {
  Level level = Level::kDynamic;
  int iterations = 1;      ///< a step
  CarriedProfile profile;  ///< kGeometric: one knot at least
};
struct Fidelity {
  int substeps = 1;
  double still_distance = -1.0;  ///< m: a muscle that moves no more in a step may sleep
  std::vector<MuscleFidelity> muscles;
};

}  // namespace thew::sim
