// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/fidelity/plan.h"
#include "sim/scene/model.h"

namespace thew::sim {

/// Chooses for each muscle the cheapest level that keeps scene.solver.tolerance. A few frames of
/// the scene (probes: the start, the fastest, the extremes of each muscle, the rest spread over the
/// motion) are simulated with a refined step and with each level; what was chosen then runs through
/// the whole clip, without skin, and is checked there on other frames, all of them in a short clip:
/// a muscle that misses takes the next level. Depends on the scene alone, not on threads or clocks.
/// `listen` may throw to end it. Error(kUsage) where no level keeps the tolerance.
FidelityPlan plan_fidelity(const Model& model, int threads,
                           const std::function<void()>& listen = {});

/// "geometric", ...
const char* level_name(Level level);

}  // namespace thew::sim
