// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/fidelity/plan.h"
#include "sim/scene/model.h"

namespace thew::sim {

/// Chooses for each muscle the cheapest level that keeps model.solver.tolerance. Some frames of the
/// scene, the probes, are simulated with a refined step and with each level: the start, the fastest
/// frame, the extremes of each muscle's length, and others spread over the motion. The choice then
/// runs through the whole clip, without skin. It is checked there on other frames, in a short clip
/// on all of them, and a muscle that misses gets the next level. Depends on the scene alone, not on
/// threads or clocks. `check_stop` is called often and may throw to end it. Error(kUsage) where no
/// level keeps the tolerance.
FidelityPlan plan_fidelity(const Model& model, int threads,
                           const std::function<void()>& check_stop = {});

/// The name of a level in reports: "asleep", "geometric", "quasi_static", "dynamic".
const char* level_name(Level level);

}  // namespace thew::sim
