// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/step.h"

namespace thew::tools {

/// A model at rest in the clip's first pose, on one thread, as a bake begins: what stands alone is
/// solved there by itself, and in play() at each frame. An interruption ends it, and play().
State settled_state(const Model& model);

/// Frames of a model, one after another on one thread.
struct Played {
  double seconds = 0.0;  ///< CPU, of all steps
  StageSeconds stages;
  State state;  ///< at the last frame
  double milliseconds_a_frame(const Model& model) const {
    return 1e3 * seconds / (model.last_frame - model.first_frame);
  }
};
/// From `start`, at the first frame, to `last` (0: the model's own). Calls on_frame(frame, state)
/// at each frame, the first one included; what it takes is not timed.
using OnState = std::function<void(int frame, State& state)>;
Played play(const Model& model, State start, int last = 0, const OnState& on_frame = {});

}  // namespace thew::tools
