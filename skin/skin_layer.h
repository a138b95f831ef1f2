// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/loop.h"
#include "skin/skin_model.h"

namespace thew::skin {

/// Binds a skin mesh to a skeleton. `below` are bones and muscles in the bind pose, and `bodies_of`
/// tells the body of each of these colliders (-1 for muscles). Each node belongs to the body of its
/// nearest bone; these shares are then smoothed over the surface.
SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings);
SkinState initial_skin(const SkinModel& model);

/// Moves the skin to the pose: bound shape, elastic equilibrium, contact with muscles and bones,
/// contact with itself (see skin_passes.h). The result depends only on the arguments, the state of
/// the step before included.
void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               const Loop& loop, SkinState& state);

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state);

}  // namespace thew::skin
