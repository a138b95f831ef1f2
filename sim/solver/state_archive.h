// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// The state at rest in the bind pose, at time -model.settle.
State initial_state(const Model& model);

/// Time, motion and searches of a state as plain numbers, and back. A state that was packed and
/// unpacked takes the same steps to the last bit; all else that a step reads is computed again.
/// unpack_state() sets the whole state. Error(kInput) where the numbers are not of this model.
std::vector<double> pack_state(const State& state);
/// The same into memory of the caller, which a bake uses for every frame.
void pack_state(const State& state, std::vector<double>& out);
void unpack_state(const Model& model, const std::vector<double>& packed, State& state);
/// Clears what searches have left, so that the next ones are as in the first step.
void forget_searches(State& state);

}  // namespace thew::sim
