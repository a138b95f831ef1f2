// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/skin_model.h"

namespace thew::skin {

/// `below` are bones and muscles in the bind pose, `bodies_of` the body that carries each collider
/// (muscles: -1). Shares follow the distance to the bodies' bones, smoothed over the surface.
SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings);
SkinState initial_skin(const SkinModel& model);

/// Moves the skin to the pose: bound shape, elastic smoothing, contact with what is below, contact
/// with itself. The result depends on the state before alone.
void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               SkinState& state);

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state);

}  // namespace thew::skin
