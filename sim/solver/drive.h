// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// Joint values at `time` (s): before 0 they go from the bind pose to the clip's first pose, in the
/// first half of scene.settle.
void joints_at(const Model& model, double time, std::vector<double>& joints);
/// When that motion ends, s (not above 0).
double bind_to_first_ends(const Model& model);

/// rad, the most that a joint turns in the frame that has begun and ends at `time`. The pose is
/// what it was.
double turn_until(const Model& model, double time, State& state);
/// Poses the skeleton and moves the bones' surfaces.
void drive_bones(const Model& model, double time, State& state);

double activation_at(const Model& model, int m, double time);

}  // namespace thew::sim
