// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/solver/health.h"
#include "sim/solver/parallel.h"

namespace thew::sim {

/// The colliders of contact and skin: all muscles, then all bones. They point into model and state.
/// set_colliders() is the same into a vector that is there, so that it need not allocate.
std::vector<Collider> colliders_of(const Model& model, const State& state);
void set_colliders(const Model& model, const State& state, std::vector<Collider>& colliders);
/// The muscles alone.
std::vector<Collider> muscles_of(const Model& model, const State& state);
void set_muscles(const Model& model, const State& state, std::vector<Collider>& colliders);
/// Muscles and bones that the skin is kept out of.
void set_felt(const Model& model, const State& state, std::vector<Collider>& colliders);
/// Sets state.props, for a step of the skin; none of them is below it.
void set_props(const Model& model, State& state);
/// Refits the tree of bone b if the bone has moved since it was fitted.
void fit_bone(const Model& model, int b, State& state);
/// Refits the trees of all muscles and bones.
void refit_all(const Model& model, Parallel& parallel, State& state);

/// Sets state.colliders for the searches and solves of this step, after the rig has moved and
/// before the next two.
void update_colliders(const Model& model, State& state);
/// Finds the contacts of every muscle with the others, the bones and itself. A contact that was
/// there in the step before keeps its multipliers.
void find_all_contacts(const Model& model, Parallel& parallel, State& state);

/// The tunnelling check, after the rig has moved and before contacts are searched for. Finds the
/// node that has gone deepest into a bone in this step, relative to that bone, if that is deeper
/// than contact.max_depth (m): it might come out on the other side. The diagnosis says how many
/// times shorter the step has to be. Refits the trees of the bones that it looks into.
std::optional<StepDiagnosis> find_tunnelling(const Model& model, State& state);

}  // namespace thew::sim
