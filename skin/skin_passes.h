// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/skin_model.h"

namespace thew::skin {

// The passes of one step of the skin, in the order in which step_skin calls them.

/// Sets turns and bound: each node's rotation and place as its bodies carry it.
void bind_to_pose(const SkinModel& model, const Pose& pose, SkinState& state);
/// Sets elastic; turns force into the displacement that it would cause.
void solve_elastic(const SkinModel& model, SkinState& state);
/// Sets x: where the step before left it, relative to the elastic shape.
void predict_skin(const SkinModel& model, SkinState& state);

/// Flesh under each node that has moved since it was looked up; all of them at first.
void look_below(const SkinModel& model, const std::vector<Collider>& below, bool first,
                SkinState& state);
/// Flesh nodes within `depth` (m) of a skin triangle from within, or through it.
void look_above(const SkinModel& model, const std::vector<Collider>& below, double depth,
                SkinState& state);
/// Skin nodes that come near the other wall of a fold, or through it.
void look_across(const SkinModel& model, SkinState& state);

/// Sets normals: of the skin, averaged over a ring so that no single triangle can turn one over.
void find_normals(const SkinModel& model, SkinState& state);
/// One sweep there and back: each node to its elastic balance, then onto its level of the flesh.
void relax(const SkinModel& model, SkinState& state);
/// Moves apart what look_across found.
void part_folds(const SkinModel& model, SkinState& state);
/// Moves triangles out over what look_above found.
void cover_triangles(const SkinModel& model, SkinState& state);

/// No node leaves its prediction by more than twice what it did a step before: what snaps, as the
/// walls of a fold do when they let go, gathers speed instead of jumping.
void ease(const SkinModel& model, SkinState& state);

/// Moves nodes that are too near the flesh out of it.
void clear_flesh(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);
/// Both ways, until no node of the skin is too near the flesh and none of the flesh pierces the
/// skin.
void cover_flesh(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);
/// Evens out what still crosses, with the ring around it, until nothing does.
void untangle(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);

/// Sets force, slip and offset for the step to come.
void remember(const SkinModel& model, SkinState& state);

/// Sets room by the fat that is left under each node and over each node of the flesh, by the planes
/// and covers that were last looked up.
void find_room(const SkinModel& model, SkinState& state);
/// Marks the nodes that are too near the flesh or in a triangle that the flesh pierces, and those
/// in and around triangles that cross.
void find_faults(const SkinModel& model, const std::vector<Collider>& below, SkinState& state,
                 std::vector<char>& marked);
/// Moves the skin to the volume that it has at rest, to rounding error; where there is no room, as
/// near as the fat allows; and not at all where it would leave the skin too near the flesh, pierced
/// or crossing whatever part of it is held.
void restore_volume(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);

/// Out of the flesh, a unit vector: along the field's gradient, with a little of the skin's normal
/// for where the gradient vanishes.
Vec3 way_out(const FleshValue& flesh, const Point& normal);
/// How far a node is moved along `way` for its field to rise by `lack` (m).
double climb(const FleshValue& flesh, const Vec3& way, double lack);

}  // namespace thew::skin
