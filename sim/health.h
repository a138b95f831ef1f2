// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/state.h"

namespace thew {

/// Clears the measures of the frame before and keeps what a failed step takes back.
void begin_frame(State& state);
void take_back(State& state);

/// After a step of h seconds: empty, or what is wrong with which node of which muscle, with value
/// and limit (not finite, beyond 10 times the rig's box, too fast, edges torn or crushed).
std::string find_trouble(const Model& model, double h, const State& state);

/// m/s, over all free nodes.
double fastest_node(const Model& model, const State& state);

}  // namespace thew
