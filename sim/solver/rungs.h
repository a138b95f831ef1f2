// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"
#include "sim/solver/step_diagnosis.h"

namespace thew::sim {

// A muscle that cannot be solved in a frame takes a rung for some frames, so that a bake ends with
// frames: first contact lets the pair pass that cannot be parted, then the muscle is its carried
// shape at its exact volume, come to within frames and left within frames. Each rung is stated.

/// The next rung from state.time on, for the muscle in trouble; false where there is none.
bool take_rung(const Model& model, const StepDiagnosis& diagnosis, State& state);
/// What a frame begins with: leaves the rungs whose time is over.
void leave_rungs(const Model& model, State& state);
/// That a step had to be split for it, where that is all.
void note_split(const StepDiagnosis& diagnosis, State& state);

/// Contact of muscle m with a collider is left out.
bool lets_pass(const State& state, int m, int other);

/// Whether the muscle is its carried shape in a step that ends at `time` (s), and takes no part in
/// the solve.
bool is_held(const Model& model, const MuscleState& now, double time);
/// Puts it there, after carry_muscle(): what it is off that shape by fades over frames.
void hold_carried(const Model& model, int m, double time, double h, MuscleState& now);
/// After the solve: a share of the carried shape, which fades over frames.
void blend_carried(const Model& model, int m, double time, double h, MuscleState& now);

}  // namespace thew::sim
