// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "sim/solver/state.h"
#include "sim/solver/step_diagnosis.h"

namespace thew::sim {

/// A frame that could not be done. Its message has all that failure.json has.
class StepFailure : public Error {
 public:
  /// At the end of the frame at `time` (s) of so many substeps.
  StepFailure(const Model& model, double time, const StepDiagnosis& diagnosis, int substeps);
  StepDiagnosis diagnosis;
  int frame = 0;     ///< the clip's first one while settling
  int substeps = 0;  ///< the last try's; of the skin 0
};

/// Clears the measures of the frame before and keeps what a failed step takes back.
void begin_frame(const Model& model, State& state);
void take_back(State& state);

/// What the step says, or the solver by an Error, of what it cannot do; other errors go on.
std::optional<StepDiagnosis> diagnose_solver(
    const std::function<std::optional<StepDiagnosis>()>& step);
/// After a step of h seconds: nothing, or what is wrong with which node of which muscle (not
/// finite, beyond 10 times the rig's box, too fast, edges torn, turned inside out, more energy than
/// rig, gravity and springs can have given).
std::optional<StepDiagnosis> diagnose_step(const Model& model, double h, const State& state);
/// The same of the skin: not finite, or beyond the rig's box.
std::optional<StepDiagnosis> diagnose_skin(const Model& model, const State& state);

/// m/s, over all free nodes.
double fastest_node(const Model& model, const State& state);

}  // namespace thew::sim
