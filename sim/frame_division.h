// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/solver/state.h"
#include "sim/solver/step_diagnosis.h"

namespace thew::sim {

/// How a frame is divided into substeps of equal length, and how often it has been divided again
/// because a try failed.
struct FrameDivision {
  double end = 0.0;                       ///< s, when the frame ends
  double length = 0.0;                    ///< s, of the frame
  int first_substeps = 1;                 ///< in the first try
  int substeps = 1;                       ///< in the present try
  int skin_steps = 1;                     ///< of the skin in the frame, 0 to `substeps`
  bool was_repeated = false;              ///< the same try has been made twice
  int halvings = 0;                       ///< since the first try, or since the last rung
  bool rests = false;                     ///< all of it is at `end`, see rest_frame()
  std::optional<StepDiagnosis> too_fast;  ///< the last diagnosis that asked for more substeps

  double step() const { return length / substeps; }  ///< s, of a substep
  /// Whether a try of the whole steps has failed.
  bool is_divided() const { return substeps > first_substeps; }
  /// s, when substep i ends; i counts from 1.
  double time_after(int i) const { return rests ? end : end - length * (substeps - i) / substeps; }
  /// Whether the skin is stepped after substep i.
  bool steps_skin_after(int i) const {
    return i * skin_steps / substeps != (i - 1) * skin_steps / substeps;
  }
};

/// The first try of the frame from state.time to `time` (s), after begin_frame(). Muscles and skin
/// are stepped often enough that no joint turns by more than SkinSettings::max_turn in a step;
/// without a skin too, so that the muscles are the same with and without it. Before the first frame
/// the skin is stepped only once joints have turned by half of that.
FrameDivision divide_frame(const Model& model, double time, State& state);

/// That of rest_frame(), after begin_frame().
FrameDivision divide_rest(const Model& model, const State& state);

/// Changes the next try of a frame, after undo_frame(), by the first of these that is left:
/// - more substeps, as many as the diagnosis asks for, where a node moves too far into a bone;
/// - the same once more, since a fault of the machine does not come back;
/// - half of the step, four times at most;
/// - the muscle's next rung (rungs.h), with as many substeps as in the first try.
/// A node that jumps into a bone however short the step is, and a solver without a solution, go to
/// a rung at once. Returns false where none is left. Sets diagnosis.cause to kJump where it is a
/// jump.
bool prepare_retry(const Model& model, StepDiagnosis& diagnosis, FrameDivision& division,
                   State& state);

}  // namespace thew::sim
