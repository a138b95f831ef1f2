// SPDX-License-Identifier: Apache-2.0
//
// One frame of the simulation: bones move and carry the muscles along, surfaces meet, springs pull,
// the multiplier restores each volume without undoing the contact, and the skin follows.
#include "sim/step.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/health.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/rungs.h"

namespace thew::sim {
namespace {

class StopWatch {
 public:
  explicit StopWatch(double& total) : total_(total), begin_(std::chrono::steady_clock::now()) {}
  ~StopWatch() {
    total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  double& total_;
  std::chrono::steady_clock::time_point begin_;
};

void move_rig(const Model& model, double time, double h, Parallel& parallel, State& state) {
  drive_bones(model, time, state);
  choose_levels(model, h, state);
  parallel.each(state.count(), [&](int m) {
    const Level level = state.muscles[m].level;
    if (level == Level::kGeometric) shape_muscle(model, m, h, state);
    if (!has_forces(level)) return;
    MuscleState& now = state.muscles[m];
    carry_muscle(model.muscles[m], state.pose, activation_at(model, m, time), h, now, now);
    if (is_held(model, now, time)) {
      now.level = Level::kGeometric;
      return hold_carried(model, m, time, h, now);
    }
    predict(model.muscles[m], h, now);
  });
}

void solve_muscles(const Model& model, double time, double h, Parallel& parallel, State& state) {
  const auto each = [&](const auto& work) {
    parallel.each(state.count(), [&](int m) {
      if (has_forces(state.muscles[m].level)) work(m);
    });
  };
  each([&](int m) { update_zone(model.muscles[m], h, state.muscles[m]); });
  const auto look = [&](int m) { remember_iterate(state.muscles[m]); };
  each(look);
  const IntegratorSteps& steps = steps_of(model.solver.integrator);
  each([&](int m) { steps.begin(model, m, h, state); });
  for (int i = 0; !steps.is_solved(model, i, state); ++i) {
    each([&](int m) {
      if (iterates(model, m, i)) steps.iterate(model, m, state);
    });
    each(look);
  }
  each([&](int m) { steps.finish(model, m, h, state); });
  // Apart: finishing reads where the others were seen, which this changes.
  each([&](int m) { blend_carried(model, m, time, h, state.muscles[m]); });
}

// What is wrong with the step before it is solved, or nothing.
std::optional<StepDiagnosis> step(const Model& model, double time, double h, Parallel& parallel,
                                  State& state, StageSeconds& seconds) {
  {
    StopWatch watch(seconds.rig);
    move_rig(model, time, h, parallel, state);
  }
  {
    StopWatch watch(seconds.contact);
    place_colliders(model, state);
    if (auto tunnelling = find_tunnelling(model, state)) return tunnelling;
    find_all_contacts(model, parallel, state);
  }
  StopWatch watch(seconds.muscles);
  solve_muscles(model, time, h, parallel, state);
  return diagnose_step(model, h, state);
}

void step_skin_of(const Model& model, Parallel& parallel, State& state) {
  refit_all(model, parallel, state);
  if (model.skinned) {
    set_muscles(model, state, state.colliders);
    step_skinned(*model.skinned, state.bodies, state.colliders, state.skin);
    return;
  }
  set_colliders(model, state, state.colliders);
  step_skin(model.skin, state.pose, state.colliders, state.skin);
}

// In as many steps of the skin a frame is taken.
int skin_steps(const Model& model, double time, State& state) {
  if (!model.has_skin || model.skinned) return 1;
  const double turn = turn_until(model, time, state);
  return std::max(1, static_cast<int>(std::ceil(turn / model.skin.settings.max_turn)));
}

// s. Frames of one length to the last bit, so that a factor of the step's matrix goes on to count.
double frame_length(const Model& model, double time, const State& state) {
  constexpr double kRounding = 1e-9;
  const double frames = (time - state.time) * model.fps, whole = std::round(frames);
  return (std::abs(frames - whole) < kRounding ? whole : frames) / model.fps;
}

std::optional<StepDiagnosis> try_frame(const Model& model, double time, int substeps,
                                       int skin_steps, Parallel& parallel, State& state,
                                       StageSeconds& seconds) {
  const double frame = frame_length(model, time, state);
  for (int i = 1; i <= substeps; ++i) {
    const double left = frame * (substeps - i) / substeps;
    const auto next = [&] {
      return step(model, time - left, frame / substeps, parallel, state, seconds);
    };
    auto diagnosis = diagnose_solver(std::ref(next));  // std::function would allocate to hold it
    if (diagnosis) {
      diagnosis->substep = i;
      return diagnosis;
    }
    if (!model.has_skin || i * skin_steps / substeps == (i - 1) * skin_steps / substeps) continue;
    StopWatch watch(seconds.skin);
    step_skin_of(model, parallel, state);
    if ((diagnosis = diagnose_skin(model, state))) return diagnosis;
  }
  return {};
}

// A motion shrinks with the step; what does not is no motion.
bool is_jump(const StepDiagnosis& whole, const StepDiagnosis& in_parts) {
  constexpr double kShrinks = 0.7;  // in two parts or more
  return in_parts.cause == Cause::kWayIntoBone && whole.muscle == in_parts.muscle &&
         in_parts.way > kShrinks * whole.way;
}

}  // namespace

void step_frame(const Model& model, double time, Parallel& parallel, State& state,
                StageSeconds& seconds) {
  constexpr int kHalvings = 4, kMostParts = 1024;
  begin_frame(model, state);
  const int skin = std::min(skin_steps(model, time, state), kMostParts);
  const int whole = std::max(substeps_of(model), skin);
  // What is too fast is taken in parts. All else once more as it was, since a fault of the machine
  // does not come back; then in halves; then on a rung.
  int substeps = whole, halvings = -1;
  std::optional<StepDiagnosis> too_fast;
  while (auto diagnosis = try_frame(model, time, substeps, skin, parallel, state, seconds)) {
    take_back(state);
    const bool jumps = too_fast && is_jump(*too_fast, *diagnosis);
    if (jumps) diagnosis->cause = Cause::kJump;
    const bool divides = !jumps && diagnosis->cause != Cause::kNoSolution;
    if (divides && diagnosis->parts > 1 && substeps * diagnosis->parts <= kMostParts) {
      substeps *= diagnosis->parts;
      too_fast = diagnosis;
      note_split(*diagnosis, state);
    } else if (divides && halvings < kHalvings) {
      if (++halvings == 0) continue;
      substeps *= 2;
      note_split(*diagnosis, state);
    } else if (take_rung(model, *diagnosis, state)) {
      substeps = whole, halvings = 0;
      too_fast.reset();
    } else {
      throw StepFailure(model, time, *diagnosis, substeps);
    }
  }
  state.time = time;
}

Settled settle(const Model& model, Parallel& parallel, State& state,
               const std::function<void()>& on_frame) {
  Settled settled;
  StageSeconds unused;
  const double frame = 1.0 / model.fps, begin = state.time, moves_until = bind_to_first_ends(model);
  while (state.time < -0.5 * frame && !settled.converged) {
    const double time = std::min(0.0, state.time + frame);
    step_frame(model, time, parallel, state, unused);
    for (const MuscleState& muscle : state.muscles) {
      settled.rungs += muscle.ladder.taken > Rung::kSubsteps;
    }
    if (on_frame) on_frame();
    settled.seconds = time - begin;
    settled.speed = fastest_node(model, state);
    settled.converged = settled.speed < model.lengths.settled_speed && time >= moves_until;
  }
  state.time = 0.0;
  return settled;
}

}  // namespace thew::sim
