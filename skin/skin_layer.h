// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/loop.h"
#include "skin/skin_model.h"
#include "skin/skin_props.h"

namespace thew::skin {

/// Binds a skin mesh to a skeleton. `below` are bones and muscles in the bind pose, and `bodies_of`
/// tells the body of each of these colliders (-1 for muscles). Each node belongs to the body of its
/// nearest bone; these shares are then smoothed over the surface. Fat that is given moves the rest
/// shape.
SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings, const SkinMaps& maps = {});
SkinState initial_skin(const SkinModel& model);

/// Share [1] of the distance to its equilibrium with the forces of the step before that the skin
/// goes in a step: in a motion, and where all that it lies on rests. Both by trial; with 0.5 a
/// resting skin swings (skin/notes.md).
inline constexpr double kReturn = 0.1, kReturnAtRest = 0.3;

/// Gives the skin a shape (m, by node) in which nothing presses on it, in place of the one that the
/// bodies alone carry: in `pose`, and on the way to it the share [0..1] of what it adds to that
/// one.
void set_carried(const SkinModel& model, const Pose& pose, const Points& shape, double share,
                 SkinState& state);

/// Moves the skin to the pose: bound shape, elastic equilibrium, contact with muscles and bones,
/// contact with itself (see skin_passes.h), props. The result depends only on the arguments, the
/// state of the step before included.
void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               const Loop& loop, SkinState& state, double share_of_return = kReturn,
               const Props& props = {});

/// The same for a skin of which turns, bound shape and what sticks are set in the state
/// (bind_to_pose() and find_stuck() in skin_passes.h set them in step_skin()).
void step_bound_skin(const SkinModel& model, const std::vector<Collider>& below, const Loop& loop,
                     SkinState& state, double share_of_return, const Props& props = {});
/// Sets what step_bound_skin() needs of a model whose rest, surface and settings are set. The
/// elastic `triangles` are of all nodes; those of the surface, which meet flesh and each other, may
/// be fewer. `hold` [1] is the weight by which each node is anchored to the bound shape besides,
/// and `slide` that of SkinMaps by node.
void finish_binding(const std::vector<Triangle>& triangles, const std::vector<double>& hold,
                    const std::vector<Collider>& below, const std::vector<double>& slide,
                    SkinModel& model);

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state);

}  // namespace thew::skin
