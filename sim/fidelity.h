// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/carried_shape.h"

namespace thew {

struct Model;
struct Muscle;
struct MuscleState;
struct State;

/// How a muscle is simulated, from the cheapest up.
enum class Level {
  kAsleep,       ///< nothing that drives it or may touch it moves: left alone
  kGeometric,    ///< its carried shape with a measured profile, at the exact volume: no forces
  kQuasiStatic,  ///< springs, contact and volume, the rest of the motion
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
  double rest = -1.0;  ///< m a step: what moves no more may sleep
  std::vector<MuscleFidelity> muscles;
};

/// A frame is as many steps.
int substeps_of(const Model& model);
/// Whether muscle m takes part in an iteration of a step, after so many that are done.
bool iterates(const Model& model, int m, int done);
bool is_quasi_static(const Model& model, int m);

/// Sets how each muscle is treated in this step; the bones are where they go.
void choose_levels(const Model& model, double h, State& state);

/// The carried shape with its profile at the exact volume, into now.x. False where no motion along
/// the volume's gradient reaches it.
bool place_carried(const Muscle& muscle, const CarriedPose& pose, const CarriedProfile& profile,
                   MuscleState& now);
/// kGeometric: puts the muscle where it belongs in state.pose and restores its volume.
void shape_muscle(const Model& model, int m, double h, State& state);

}  // namespace thew
