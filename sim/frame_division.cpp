// SPDX-License-Identifier: Apache-2.0
#include "sim/frame_division.h"

#include <algorithm>
#include <cmath>

#include "sim/solver/drive.h"
#include "sim/solver/levels.h"
#include "sim/solver/rungs.h"

namespace thew::sim {
namespace {

constexpr int kMaxHalvings = 4;
constexpr int kMaxSubsteps = 1024;  // of a frame

// Whether the skin is not stepped in a frame in which joints turn by `angle` (rad): before the
// first frame, on the way to its pose, where it comes to rest (settle.h). It need not follow before
// joints have turned by half of what they may in a step of it.
bool leaves_skin(const Model& model, double angle, State& state) {
  if (state.time >= 0.0 || state.way) return false;
  state.unfollowed += angle;
  if (state.unfollowed <= 0.5 * model.skin.settings.max_turn) return true;
  state.unfollowed = 0.0;
  return false;
}

// s. Frames have one length to the last bit, so that the step's matrix stays the same and its
// factor can be used again.
double frame_length(const Model& model, double time, const State& state) {
  constexpr double kRounding = 1e-9;  // frames
  const double frames = (time - state.time) * model.fps, whole = std::round(frames);
  return (std::abs(frames - whole) < kRounding ? whole : frames) / model.fps;
}

// The displacement of a motion becomes shorter with the step. One that does not is a jump.
bool is_jump(const StepDiagnosis& before, const StepDiagnosis& divided) {
  constexpr double kShrinks = 0.7;  // of the displacement, at half of the step or less
  return divided.cause == Cause::kTunnelling && before.muscle == divided.muscle &&
         divided.displacement > kShrinks * before.displacement;
}

}  // namespace

FrameDivision divide_frame(const Model& model, double time, State& state) {
  FrameDivision division;
  division.end = time;
  division.length = frame_length(model, time, state);
  const double angle = turn_until(model, time, state);
  const double steps = std::ceil(angle / model.skin.settings.max_turn);
  division.skin_steps = static_cast<int>(std::clamp(steps, 1.0, 1.0 * kMaxSubsteps));
  division.first_substeps = std::max(substeps_of(model), division.skin_steps);
  division.substeps = division.first_substeps;
  if (leaves_skin(model, angle, state)) division.skin_steps = 0;
  return division;
}

FrameDivision divide_rest(const Model& model, const State& state) {
  FrameDivision division;
  division.end = state.time;
  division.length = 1.0 / model.fps;
  division.rests = true;
  division.skin_steps = 0;
  return division;
}

bool prepare_retry(const Model& model, StepDiagnosis& diagnosis, FrameDivision& division,
                   State& state) {
  const bool jumps = division.too_fast && is_jump(*division.too_fast, diagnosis);
  if (jumps) diagnosis.cause = Cause::kJump;
  const bool can_divide = !jumps && diagnosis.cause != Cause::kNoSolution;
  if (can_divide && diagnosis.divisor > 1 &&
      diagnosis.divisor <= kMaxSubsteps / division.substeps) {
    division.substeps *= diagnosis.divisor;
    division.too_fast = diagnosis;
    note_division(diagnosis, state);
    return true;
  }
  if (can_divide && !division.was_repeated) {
    division.was_repeated = true;
    return true;
  }
  if (can_divide && division.halvings < kMaxHalvings) {
    division.substeps *= 2;
    ++division.halvings;
    note_division(diagnosis, state);
    return true;
  }
  if (!take_rung(model, diagnosis, state)) return false;
  division.substeps = division.first_substeps;
  division.was_repeated = true;
  division.halvings = 0;
  division.too_fast.reset();
  return true;
}

}  // namespace thew::sim
