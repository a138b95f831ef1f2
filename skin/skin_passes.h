// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/loop.h"
#include "skin/skin_model.h"

namespace thew::skin {

struct Props;  // skin_props.h

// The passes of one step of the skin, in the order in which step_skin calls them.

/// Sets turns and bound: the rotation and position of each node as its bodies carry it, by dual
/// quaternion blending (Kavan et al. 2008).
void bind_to_pose(const SkinModel& model, const Pose& pose, SkinState& state);
/// Sets stuck of the nodes that do not slide freely.
void find_stuck(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);
/// Least length of an edge along its rotated direction, over its rest length; by trial.
inline constexpr double kMinEdge = 0.1;
/// Sets turned and elastic, the latter to the positions of least elastic energy, and force to the
/// displacement that the forces of the step before cause.
void solve_elastic(const SkinModel& model, const Loop& loop, SkinState& state);
/// Sets x to the elastic shape plus the offset that the step before left, and goes the share [1] of
/// the way to the equilibrium with the forces of that step.
void predict_skin(const SkinModel& model, double share_of_return, SkinState& state);

/// Searches for the flesh below each node that has moved by Lengths::lookup_motion since its last
/// search; below all nodes if `first`.
void find_flesh_below(const SkinModel& model, const std::vector<Collider>& below, bool first,
                      const Loop& loop, SkinState& state);
/// Finds nodes of the flesh that lie within `depth` (m) below a triangle of the skin or have come
/// through it. In a step the `first` search looks `ahead` (m) as well, so that the later ones of
/// the same depth look only for nodes that the skin may have come near since.
void find_covers(const SkinModel& model, const std::vector<Collider>& below, double depth,
                 double ahead, bool first, const Loop& loop, SkinState& state);
/// Whether a point of an open surface lies on its border: what is nearest to that lies beside the
/// surface, not under it.
bool is_on_border(const Surface& surface, const ClosestPoint& near);
SkinPlane plane_at(const ClosestPoint& near, double level);
/// Finds nodes of the skin that are near the other wall of a fold or have come through it.
void find_folds(const SkinModel& model, const Loop& loop, SkinState& state);

/// Moves the rest shape to the fat (m, by node; empty: nothing) over the flesh, along `normals`
/// where the flesh gives no direction.
void shape_fat(const std::vector<Collider>& below, const std::vector<double>& fat,
               const std::vector<Vec3>& normals, SkinModel& model);
/// Sets stick and sites of the model, whose edges have this mean length (m).
void bind_slide(const std::vector<Collider>& below, const std::vector<double>& slide,
                double mean_edge, SkinModel& model);
/// Sets wall_level of the model, with all else of it set.
void find_wall_levels(SkinModel& model);

/// Sets own_normals and normals: the latter are averaged over the neighbours, so that no single
/// triangle can reverse one.
void find_normals(const SkinModel& model, const Loop& loop, SkinState& state);
/// One sweep forwards and one backwards over the nodes: each goes to its elastic equilibrium, then
/// out to its level of the flesh field. `new_normals`: normals or planes are not those of the last
/// call.
void relax(const SkinModel& model, const Loop& loop, bool new_normals, SkinState& state);
/// Moves apart the walls that find_folds found.
void part_folds(const SkinModel& model, SkinState& state);
/// Moves triangles out over the nodes of the flesh that find_covers found, as far as their covers
/// ask less what is `spared` (m). What lacks more than `reach` (m) is left, what lacks half of it
/// or less moves whole.
void cover_triangles(const SkinModel& model, double spared, double reach, SkinState& state);

/// Limits how far each node is from its prediction, to twice the distance of the step before plus
/// Lengths::free_correction. So skin that snaps, such as the walls of a fold as they come apart,
/// gathers speed instead of jumping.
void limit_corrections(const SkinModel& model, SkinState& state);

/// Moves nodes that are nearer to the flesh than their least distance out of it.
void leave_flesh(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);
/// Moves nodes of the skin out of the flesh and triangles over nodes of the flesh in turn, until no
/// node is too near and none pierces the skin, or the rounds are over.
void cover_flesh(const SkinModel& model, const std::vector<Collider>& below, const Loop& loop,
                 SkinState& state);
/// Smooths triangles of the skin that cross each other, and their neighbours, in rounds, until none
/// cross or the rounds are over. A round after which more of them cross is undone and is the last.
void untangle(const SkinModel& model, const std::vector<Collider>& below, SkinState& state);

/// Sets force, slip, offset and correction for the next step.
void store_motion(const SkinModel& model, SkinState& state);

/// Sets room: the fat that is left below each node and over each node of the flesh, by the planes
/// and covers of the last search.
void find_room(const SkinModel& model, const Loop& loop, SkinState& state);
/// Marks nodes that are too near the flesh, nodes of triangles that the flesh pierces, and nodes in
/// and around triangles that cross.
void find_faults(const SkinModel& model, const std::vector<Collider>& below, SkinState& state,
                 std::vector<char>& marked);
/// Moves the skin to the volume of its rest shape, to rounding error, or as near as the fat allows.
/// Nodes at which this causes a fault (find_faults) keep their position, and the others move
/// farther; so do nodes at props (`held`). If there are still faults at the end, the skin stays as
/// it was.
void restore_volume(const SkinModel& model, const std::vector<Collider>& below, const Props& props,
                    const Loop& loop, SkinState& state);

}  // namespace thew::skin
