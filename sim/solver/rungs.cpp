// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/rungs.h"

#include <algorithm>

#include "muscles/volume.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"

namespace thew::sim {
namespace {

// Frames: in which the muscle is blended to its carried shape, is that shape, and is blended back;
// and in which a pair has no contact.
constexpr double kBlendInFrames = 2.0, kCarriedFrames = 1.0, kBlendOutFrames = 3.0,
                 kPairFrames = 3.0;

double frames_since(const Model& model, const MuscleState& now, double time) {
  return (time - now.ladder.since) * model.fps;
}

bool is_on(const MuscleState& now, Rung rung) { return now.ladder.rung == rung; }

// A muscle that was not solved keeps no contacts, so that its multipliers begin at 0.
void forget_contact(MuscleState& now) {
  static_cast<ContactMotion&>(now) = {};
  now.memory.others.clear();
  now.face_memory.others.clear();
}

// Restores the volume along the authored weights and sets velocity and volume error. A volume that
// cannot be reached is counted in `unreached`.
void restore(const Model& model, int m, double h, MuscleState& now) {
  const Muscle& muscle = model.muscles[m];
  now.unreached += !restore_volume(muscle, now.volume, now.x);
  for (size_t i = 0; i < now.x.size(); ++i) now.v[i] = (now.x[i] - now.start[i]) * (1.0 / h);
  now.previous_iterate = now.x;
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace

bool take_rung(const Model& model, const StepDiagnosis& diagnosis, State& state) {
  if (!model.solver.rungs || diagnosis.muscle < 0) return false;
  MuscleState& now = state.muscles[diagnosis.muscle];
  LadderState& ladder = now.ladder;
  if (is_on(now, Rung::kCarried) && ladder.since == state.time)
    return false;  // it failed on this rung
  if (ladder.rung == Rung::kNone && diagnosis.other >= 0) {
    ladder = {Rung::kPairLetPass, state.time, diagnosis.other};
  } else {
    ladder = {Rung::kCarried, state.time};
  }
  ladder.frame_rung = ladder.rung;
  ladder.cause = diagnosis.cause;
  return true;
}

void leave_rungs(const Model& model, State& state) {
  for (MuscleState& now : state.muscles) {
    LadderState& ladder = now.ladder;
    const double frames = is_on(now, Rung::kCarried)
                              ? kBlendInFrames + kCarriedFrames + kBlendOutFrames
                              : kPairFrames;
    const bool is_over = frames_since(model, now, state.time) >= (1.0 - 1e-9) * frames;
    if (ladder.rung == Rung::kNone || is_over) {
      ladder = {};
    } else {
      ladder.frame_rung = ladder.rung;
    }
  }
}

void note_division(const StepDiagnosis& diagnosis, State& state) {
  if (diagnosis.muscle < 0) return;
  LadderState& ladder = state.muscles[diagnosis.muscle].ladder;
  if (ladder.frame_rung != Rung::kNone) return;
  ladder.frame_rung = Rung::kSubsteps;
  ladder.cause = diagnosis.cause;
}

bool ignores_pair(const State& state, int m, int other) {
  const auto passes = [&](int one, int it) {
    const LadderState& ladder = state.muscles[one].ladder;
    return ladder.rung == Rung::kPairLetPass && ladder.passes == it;
  };
  return passes(m, other) || (other < state.count() && passes(other, m));
}

bool follows_carried_shape(const Model& model, const MuscleState& now, double time) {
  return is_on(now, Rung::kCarried) &&
         frames_since(model, now, time) <= (1.0 + 1e-9) * (kBlendInFrames + kCarriedFrames);
}

void follow_carried_shape(const Model& model, int m, double time, double before, double h,
                          MuscleState& now) {
  const double left = std::max(0.0, kBlendInFrames - frames_since(model, now, time));
  const double left_before = kBlendInFrames - frames_since(model, now, before);
  const double share = left_before > 0.0 ? std::min(1.0, left / left_before) : 0.0;
  now.start = now.x;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Point target_before = now.target[i] - h * now.target_velocity[i];
    now.x[i] = now.target[i] + share * (now.start[i] - target_before);
  }
  forget_contact(now);
  restore(model, m, h, now);
}

void blend_with_carried_shape(const Model& model, int m, double time, double h, MuscleState& now) {
  if (!is_on(now, Rung::kCarried)) return;
  const double share =
      1.0 - (frames_since(model, now, time) - kBlendInFrames - kCarriedFrames) / kBlendOutFrames;
  if (!(share > 0.0)) return;
  for (size_t i = 0; i < now.x.size(); ++i) now.x[i] += share * (now.target[i] - now.x[i]);
  restore(model, m, h, now);
}

}  // namespace thew::sim
