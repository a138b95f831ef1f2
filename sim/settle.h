// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"
#include "sim/step.h"

namespace thew::sim {

struct Settled {
  double seconds = 0.0;    ///< simulated until it ended
  double speed = 0.0;      ///< m/s, over the last frame, of the muscles' fastest free node
  int rungs = 0;           ///< frames of muscles that a rung stood in for (rungs.h)
  bool converged = false;  ///< it was below Lengths::settled_speed
};
/// Muscles that a rung stood in for in the last frame.
int muscles_on_rungs(const State& state);

/// From rest in the bind pose, at state.time = -model.settle, to rest in the clip's first pose at
/// time 0. Ends early where the muscles are at rest before. `on_frame` is called after each frame
/// and may throw to end it. StepFailure as of step_frame().
Settled settle(const Model& model, Parallel& parallel, State& state,
               const std::function<void()>& on_frame = {});

/// Steps of the skin alone until it hardly moves. Adds to `seconds`.
void bring_skin_to_rest(const Model& model, Parallel& parallel, State& state,
                        StageSeconds& seconds);

}  // namespace thew::sim
