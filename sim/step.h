// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// Wall seconds by stage of the step. They go to the report and nothing depends on them.
struct StageSeconds {
  double rig = 0.0, contact = 0.0, muscles = 0.0, skin = 0.0;
};

/// Advances bones, muscles and skin from state.time to `time` (s), in substeps_of(model) substeps
/// at least. Where the scene gives a tolerance, model.fidelity has to hold what plan_fidelity()
/// chose. A try that fails its health check is undone and the frame is tried again
/// (frame_division.h). StepFailure where no further try is left; the state is then the one before
/// the frame. Adds to `seconds`.
void step_frame(const Model& model, double time, Parallel& parallel, State& state,
                StageSeconds& seconds);

}  // namespace thew::sim
