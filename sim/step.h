// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"
#include "sim/stage_clock.h"

namespace thew::sim {

/// Seconds by stage of the step. No result depends on them.
struct StageSeconds {
  Seconds rig, contact, muscles, skin;
};

/// Advances bones, muscles and skin from state.time to `time` (s), in substeps_of(model) substeps
/// at least. Where the scene gives a tolerance, model.fidelity has to hold what plan_fidelity()
/// chose. A try that fails its health check is undone and the frame is tried again
/// (frame_division.h). StepFailure where no further try is left; the state is then the one before
/// the frame. Adds to `seconds`.
void step_frame(const Model& model, double time, Parallel& parallel, State& state,
                StageSeconds& seconds);

/// The same on a LoneWay where bones and time stay: each muscle, which has no inertia, comes nearer
/// to rest in contact with the others. Without the skin.
void rest_frame(const Model& model, Parallel& parallel, State& state, StageSeconds& seconds);
/// A step of the skin alone, which brings it nearer to rest.
void rest_skin(const Model& model, double share_of_return, Parallel& parallel, State& state,
               StageSeconds& seconds);

}  // namespace thew::sim
