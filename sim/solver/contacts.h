// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/solver/health.h"
#include "sim/solver/parallel.h"

namespace thew::sim {

/// Muscles, then bones, as contact and skin see them; or into memory that is there.
std::vector<Collider> colliders_of(const Model& model, const State& state);
void set_colliders(const Model& model, const State& state, std::vector<Collider>& colliders);
/// The muscles alone.
std::vector<Collider> muscles_of(const Model& model, const State& state);
void set_muscles(const Model& model, const State& state, std::vector<Collider>& colliders);
/// The tree of a bone, where it is not of the surface now.
void fit_bone(const Model& model, int b, State& state);
/// The trees that both look into.
void refit_all(const Model& model, Parallel& parallel, State& state);

/// Sets state.colliders as the searches and solves of this step see them, once the rig has moved:
/// before the next two.
void place_colliders(const Model& model, State& state);
/// Contacts of every muscle with the others and the bones; one that goes on keeps its multiplier.
void find_all_contacts(const Model& model, Parallel& parallel, State& state);

/// After the rig has moved and before contacts are looked for: the node that has gone farthest
/// beyond a bone's surface in this step, as the bone sees it, if that is deeper than
/// contact.max_depth, from where it might come out on the other side; and in how many parts the
/// step has to be taken. Fits the bones' trees where it needs them.
std::optional<StepDiagnosis> find_tunnelling(const Model& model, State& state);

}  // namespace thew::sim
