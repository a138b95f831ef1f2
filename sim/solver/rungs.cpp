// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/rungs.h"

#include <algorithm>

#include "muscles/volume.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"

namespace thew::sim {
namespace {

// Frames: to come to the carried shape, to be it, to leave it; and without a pair's contact.
constexpr double kComes = 2.0, kStays = 1.0, kLeaves = 3.0, kPasses = 3.0;

double frames_since(const Model& model, const MuscleState& now, double time) {
  return (time - now.ladder.since) * model.fps;
}

bool is_on(const MuscleState& now, Rung rung) { return now.ladder.rung == rung; }

// It begins anew when it is solved again.
void forget_contact(MuscleState& now) {
  static_cast<ContactMotion&>(now) = {};
  now.memory.others.clear();
  now.face_memory.others.clear();
}

// The volume along the authored directions; where none is reached it is counted.
void restore(const Model& model, int m, double h, MuscleState& now) {
  const Muscle& muscle = model.muscles[m];
  now.unreached += !reach_volume(muscle, now.volume, now.x);
  for (size_t i = 0; i < now.x.size(); ++i) now.v[i] = (now.x[i] - now.start[i]) * (1.0 / h);
  now.previous_iterate = now.x;
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace

bool take_rung(const Model& model, const StepDiagnosis& diagnosis, State& state) {
  if (!model.solver.rungs || diagnosis.muscle < 0) return false;
  MuscleState& now = state.muscles[diagnosis.muscle];
  LadderMotion& ladder = now.ladder;
  if (is_on(now, Rung::kCarried) && ladder.since == state.time) return false;  // it does not help
  if (ladder.rung == Rung::kNone && diagnosis.other >= 0) {
    ladder = {Rung::kPairLetPass, state.time, diagnosis.other};
  } else {
    ladder = {Rung::kCarried, state.time};
  }
  ladder.taken = ladder.rung;
  ladder.because = diagnosis.cause;
  return true;
}

void leave_rungs(const Model& model, State& state) {
  for (MuscleState& now : state.muscles) {
    LadderMotion& ladder = now.ladder;
    const double most = is_on(now, Rung::kCarried) ? kComes + kStays + kLeaves : kPasses;
    const bool is_over = frames_since(model, now, state.time) >= (1.0 - 1e-9) * most;
    if (ladder.rung == Rung::kNone || is_over) {
      ladder = {};
    } else {
      ladder.taken = ladder.rung;
    }
  }
}

void note_split(const StepDiagnosis& diagnosis, State& state) {
  if (diagnosis.muscle < 0) return;
  LadderMotion& ladder = state.muscles[diagnosis.muscle].ladder;
  if (ladder.taken != Rung::kNone) return;
  ladder.taken = Rung::kSubsteps;
  ladder.because = diagnosis.cause;
}

bool lets_pass(const State& state, int m, int other) {
  const auto passes = [&](int one, int it) {
    const LadderMotion& ladder = state.muscles[one].ladder;
    return ladder.rung == Rung::kPairLetPass && ladder.passes == it;
  };
  return passes(m, other) || (other < state.count() && passes(other, m));
}

bool is_held(const Model& model, const MuscleState& now, double time) {
  return is_on(now, Rung::kCarried) &&
         frames_since(model, now, time) <= (1.0 + 1e-9) * (kComes + kStays);
}

void hold_carried(const Model& model, int m, double time, double h, MuscleState& now) {
  const double left = std::max(0.0, kComes - frames_since(model, now, time));
  const double left_before = kComes - frames_since(model, now, time - h);
  const double share = left_before > 0.0 ? std::min(1.0, left / left_before) : 0.0;
  now.start = now.x;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Point before = now.target[i] - h * now.target_velocity[i];
    now.x[i] = now.target[i] + share * (now.start[i] - before);
  }
  forget_contact(now);
  restore(model, m, h, now);
}

void blend_carried(const Model& model, int m, double time, double h, MuscleState& now) {
  if (!is_on(now, Rung::kCarried)) return;
  const double share = 1.0 - (frames_since(model, now, time) - kComes - kStays) / kLeaves;
  if (!(share > 0.0)) return;
  for (size_t i = 0; i < now.x.size(); ++i) now.x[i] += share * (now.target[i] - now.x[i]);
  restore(model, m, h, now);
}

}  // namespace thew::sim
