// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/step.h"

namespace thew::sim {

/// Whether each frame of the model is solved by itself: quasi_static has no memory of the frame
/// before, so that frames may be baked in any order and by any number of machines.
bool stands_alone(const Model& model);

/// Sets the state to that of the pose at `time` (s, not below 0), whatever it was before. The way
/// goes from the bind pose evenly to that pose, in as many steps as the pose is far, and ends when
/// muscles and skin have come to rest there. `on_step` is called between the steps and may throw to
/// end it. StepFailure as of step_frame(). After either the state is as it was.
void solve_lone_frame(const Model& model, double time, Parallel& parallel, State& state,
                      StageSeconds& seconds, const std::function<void()>& on_step = {});

}  // namespace thew::sim
