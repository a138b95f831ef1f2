// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"
#include "sim/solver/step_diagnosis.h"

namespace thew::sim {

// A rung stands in for the solve of a muscle that fails in a frame, for some frames, so that the
// bake can go on. The first rung leaves out contact between the two bodies that cannot be parted.
// The second one makes the muscle its carried shape at its exact volume, and blends it in and out
// over some frames. The report lists every rung that was taken.

/// Puts the muscle of the diagnosis on its next rung, from state.time on. False where there is
/// none, where the scene allows none (solver.rungs), or where the diagnosis is of no muscle.
bool take_rung(const Model& model, const StepDiagnosis& diagnosis, State& state);
/// Ends the rungs whose frames are over, and forgets the rung and cause that the frame before
/// reported. Called at the beginning of a frame.
void leave_rungs(const Model& model, State& state);
/// Notes for the report that the frame was divided because of this muscle, unless it has already
/// noted a higher rung.
void note_division(const StepDiagnosis& diagnosis, State& state);

/// Whether contact of muscle m with the collider `other` is left out, because one of them is on the
/// rung Rung::kPairLetPass.
bool ignores_pair(const State& state, int m, int other);

/// Whether the muscle takes no part in the solve of a step that ends at `time` (s), because it is
/// on the rung Rung::kCarried and is not yet being blended out.
bool follows_carried_shape(const Model& model, const MuscleState& now, double time);
/// Sets such a muscle in a step of h seconds from `before` to `time` (s), after carry_muscle(). Its
/// nodes' displacement from the carried shape goes to 0 over the first frames of the rung.
void follow_carried_shape(const Model& model, int m, double time, double before, double h,
                          MuscleState& now);
/// After the solve of a step: mixes a share of the carried shape into the muscle's positions while
/// it is being blended out. The share goes to 0 over some frames. Does nothing for other muscles.
void blend_with_carried_shape(const Model& model, int m, double time, double h, MuscleState& now);

}  // namespace thew::sim
