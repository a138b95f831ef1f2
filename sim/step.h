// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// Wall seconds by stage of the step, for the report only.
struct StageSeconds {
  double rig = 0.0, contact = 0.0, muscles = 0.0, skin = 0.0;
};

/// Advances bones, muscles and skin from state.time to `time` (s), in substeps_of(model) steps.
/// Where the scene gives a tolerance model.fidelity holds what plan_fidelity() chose. What fails
/// its health check is taken back and tried again, first as it was, then in halves, four times at
/// most; then its muscle takes a rung (rungs.h). Where there is none left, StepFailure, and the
/// state is the one before the frame.
void step_frame(const Model& model, double time, Parallel& parallel, State& state,
                StageSeconds& seconds);

/// From rest in the bind pose, at state.time = -scene.settle, to rest in the clip's first pose at
/// time 0. `on_frame` may throw to end it.
struct Settled {
  double seconds = 0.0;    ///< simulated
  double speed = 0.0;      ///< m/s, the fastest node at the end
  int rungs = 0;           ///< frames of muscles that were not solved, see rungs.h
  bool converged = false;  ///< below Lengths::settled in a second
};
Settled settle(const Model& model, Parallel& parallel, State& state,
               const std::function<void()>& on_frame = {});

}  // namespace thew::sim
