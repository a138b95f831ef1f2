// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// Joint values at `time` (s): before 0 they go from the bind pose to the clip's first pose, in the
/// first half of scene.settle.
void joints_at(const Model& model, double time, std::vector<double>& joints);
/// When that motion ends, s (not above 0).
double bind_to_first_ends(const Model& model);

/// The largest angle (rad) by which a joint turns in the frame that begin_frame() has begun and
/// that ends at `time` (s). The pose of the state is scratch; afterwards it is what it was.
double turn_until(const Model& model, double time, State& state);
/// Poses the skeleton at `time` (s) and moves the bones' surfaces.
void drive_bones(const Model& model, double time, State& state);
/// Moves each muscle with the bones, in a step of h seconds that ends at `time` (s): a geometric
/// one becomes its carried shape; one with forces gets its targets, rest lengths and first guess,
/// or is its carried shape where it is on that rung. After drive_bones() and choose_levels().
void drive_muscles(const Model& model, double time, double h, Parallel& parallel, State& state);

}  // namespace thew::sim
