// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/parallel.h"
#include "sim/state.h"

namespace thew {

/// Joint values at `time` (s): before 0 they go from the bind pose to the clip's first pose, in the
/// first half of scene.settle.
void joints_at(const Model& model, double time, std::vector<double>& joints);
/// When that motion ends, s (not above 0).
double bind_to_first_ends(const Model& model);

/// rad, the most that a joint turns from where it is now until `time`.
double turn_until(const Model& model, double time, const State& state);
/// Poses the skeleton and moves the bones' surfaces.
void drive_bones(const Model& model, double time, State& state);

double activation_at(const Model& model, int m, double time);

/// Muscles, then bones, as contact and skin see them.
std::vector<Collider> colliders_of(const Model& model, const State& state);
/// The muscles alone.
std::vector<Collider> muscles_of(const Model& model, const State& state);
/// The tree of a bone, where it is not of the surface now.
void fit_bone(const Model& model, int b, State& state);
/// The trees that both look into.
void refit_all(const Model& model, Parallel& parallel, State& state);

/// Contacts of every muscle with the others and the bones; one that goes on keeps its multiplier.
void find_all_contacts(const Model& model, Parallel& parallel, State& state);

}  // namespace thew
