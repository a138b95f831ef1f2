// SPDX-License-Identifier: Apache-2.0
#include "sim/settle.h"

#include <algorithm>

#include "sim/solver/drive.h"
#include "sim/solver/health.h"
#include "sim/step.h"

namespace thew::sim {

Settled settle(const Model& model, Parallel& parallel, State& state,
               const std::function<void()>& on_frame) {
  Settled settled;
  StageSeconds unused;
  const double frame = 1.0 / model.fps, begin = state.time, moves_until = bind_to_first_ends(model);
  while (state.time < -0.5 * frame && !settled.converged) {
    const double time = std::min(0.0, state.time + frame);
    step_frame(model, time, parallel, state, unused);
    for (const MuscleState& muscle : state.muscles) {
      settled.rungs += muscle.ladder.frame_rung > Rung::kSubsteps;
    }
    if (on_frame) on_frame();
    settled.seconds = time - begin;
    settled.speed = fastest_node(model, state);
    settled.converged = settled.speed < model.lengths.settled_speed && time >= moves_until;
  }
  state.time = 0.0;
  return settled;
}

}  // namespace thew::sim
