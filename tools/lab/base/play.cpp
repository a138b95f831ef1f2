// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/base/play.h"

#include <utility>

#include "sim/lone_frame.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "tools/base/signals.h"
#include "tools/lab/base/measures.h"

namespace thew::tools {

State settled_state(const Model& model) {
  Parallel one(1);
  State state = initial_state(model);
  if (stands_alone(model)) {
    StageSeconds stages;
    solve_lone_frame(model, 0.0, one, state, stages, [] { stop_if_interrupted(); });
    return state;
  }
  settle(model, one, state, [] { stop_if_interrupted(); });
  return state;
}

Played play(const Model& model, State start, int last, const OnState& on_frame) {
  Parallel one(1);
  Played played;
  played.state = std::move(start);
  if (last == 0) last = model.last_frame;
  if (on_frame) on_frame(model.first_frame, played.state);
  for (int frame = model.first_frame + 1; frame <= last; ++frame) {
    stop_if_interrupted();
    const double begin = cpu_seconds();
    const double time = (frame - model.first_frame) / model.fps;
    if (stands_alone(model)) {
      solve_lone_frame(model, time, one, played.state, played.stages);
    } else {
      step_frame(model, time, one, played.state, played.stages);
    }
    played.seconds += cpu_seconds() - begin;
    if (on_frame) on_frame(frame, played.state);
  }
  return played;
}

}  // namespace thew::tools
