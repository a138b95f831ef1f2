// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "sim/solver/state.h"
#include "sim/solver/step_diagnosis.h"

namespace thew::sim {

/// A frame that no try could finish. Its message says all that failure.json says.
class StepFailure : public Error {
 public:
  /// Of the last try of the frame that ends at `time` (s), which had so many substeps.
  StepFailure(const Model& model, double time, const StepDiagnosis& diagnosis, int substeps);
  StepDiagnosis diagnosis;
  int frame = 0;     ///< the frame's number; the clip's first one while settling
  int substeps = 0;  ///< of the last try; 0 where the skin failed
};

/// Clears the measures of the frame before, ends rungs whose frames are over, and keeps the motion
/// of muscles, skin and bodies for undo_frame().
void begin_frame(const Model& model, State& state);
/// Restores the motion that begin_frame() kept, after a failed try. The rungs stay as they are.
void undo_frame(const Model& model, State& state);

/// Calls the step and returns its diagnosis. NoSolution of the solver becomes a diagnosis too;
/// other exceptions are passed on.
std::optional<StepDiagnosis> diagnose_solver(
    const std::function<std::optional<StepDiagnosis>()>& step);
/// The health check after a step of h seconds. Returns the first fault it finds, with muscle and
/// node: a position that is not finite or beyond 10 times the rig's extent, a speed that crosses
/// the rig in one step, an edge longer than 10 times its rest length, a muscle without volume or
/// turned inside out, more energy than rig, gravity and springs can have given. Nothing if there is
/// none.
std::optional<StepDiagnosis> diagnose_step(const Model& model, double h, const State& state);
/// The same of the skin: a position that is not finite or beyond 10 times the rig's extent.
std::optional<StepDiagnosis> diagnose_skin(const Model& model, const State& state);

}  // namespace thew::sim
