// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// At rest in the bind pose.
State initial_state(const Model& model);

/// Time, motion and searches as plain numbers, and back: a state that has gone through them takes
/// every step to come to the same bytes. What else a step reads it finds anew.
std::vector<double> pack_state(const State& state);
void unpack_state(const Model& model, const std::vector<double>& packed, State& state);
/// Searches begin anew, as those of the first step.
void forget_searches(State& state);

}  // namespace thew::sim
