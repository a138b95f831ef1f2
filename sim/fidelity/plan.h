// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/scene/fidelity_levels.h"

namespace thew::sim {

/// What is said of the choice; lengths in m, against the refined step. Work is counted: nodes times
/// iterations and searches for a closest point, a frame.
struct ChosenMuscle {
  Level level = Level::kDynamic;  ///< kAsleep: it slept through the whole clip
  int iterations = 0;             ///< a step, 0 without forces
  std::string because;
  double probed_error = 0.0, checked_error = 0.0;  ///< largest of any node, in the frames below
  double refined_error = 0.0;  ///< of the refined step itself, which the tolerance has to bear too
  double work = 0.0, uniform_work = 0.0;
};
struct FidelityPlan {
  Fidelity fidelity;
  std::vector<ChosenMuscle> muscles;
  std::vector<int> probed, checked;                  ///< frames
  int uniform_substeps = 1, uniform_iterations = 1;  ///< what all muscles alike would need
  bool uniform_keeps = false;  ///< false: even that misses it, and nothing finer was tried
  double work = 0.0, uniform_work = 0.0;
  double probe_work = 0.0;          ///< in all, paid once
  std::vector<std::string> raised;  ///< what missed the tolerance at first, and what it got instead
};

}  // namespace thew::sim
