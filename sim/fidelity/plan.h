// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/scene/fidelity_levels.h"

namespace thew::sim {

/// What a muscle got under a tolerance, and its errors in m against the refined step. Work is
/// counted and not timed: nodes times iterations plus searches for a closest point, per frame.
struct ChosenMuscle {
  Level level = Level::kDynamic;  ///< kAsleep: it was asleep in the whole clip
  int iterations = 0;             ///< per step; 0 at a level without forces
  std::string reason;             ///< for the report
  /// The largest of any node, in the frames FidelityPlan::probed and ::checked.
  double probed_error = 0.0, checked_error = 0.0;
  double refined_error = 0.0;  ///< of the refined step itself; it is taken off the tolerance
  double work = 0.0, uniform_work = 0.0;
};
struct FidelityPlan {
  Fidelity fidelity;
  std::vector<ChosenMuscle> muscles;
  std::vector<int> probed, checked;  ///< frames
  /// What all muscles would need if all had the same.
  int uniform_substeps = 1, uniform_iterations = 1;
  bool uniform_keeps =
      false;  ///< whether these keep the tolerance; if not, nothing finer was tried
  double work = 0.0, uniform_work = 0.0;
  double probe_work = 0.0;          ///< of planning, in nodes and searches
  std::vector<std::string> raised;  ///< one line for each muscle that missed the tolerance at first
};

}  // namespace thew::sim
