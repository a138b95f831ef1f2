// SPDX-License-Identifier: Apache-2.0
//
// The whole method on one page, to be read from the end: a frame, a substep, and the solve in it.
// "Eq." is an equation of the paper: Hong, Jung, Choi, Welch, "Fast Volume Preservation for a
// Mass-Spring System", 2006. method.md explains each line and what of the paper is mended.
#include "sim/step.h"

#include <functional>

#include "sim/frame_division.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/health.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/parting.h"
#include "sim/solver/rungs.h"

namespace thew::sim {
namespace {

// Springs, contact and volume of all muscles, solved together. The volume V (eq. 1) and its
// gradient (eqs 2-5) give the multiplier that restores it (eqs 9-14). It is part of each
// integrator's iteration: explicit.cpp is the paper's own integrator, local_global.cpp the default.
void solve_muscles(const Model& model, double time, double h, Parallel& parallel, State& state) {
  const IntegratorSteps& integrator = steps_of(model.solver.integrator);
  const auto each = [&](const auto& work) {
    parallel.each(state.count(), [&](int m) {
      if (has_forces(state.muscles[m].level)) work(m);
    });
  };
  each([&](int m) { update_zone(model.muscles[m], h, state.muscles[m]); });  // eq. 15
  each([&](int m) { update_previous_iterate(state.muscles[m]); });
  each([&](int m) { integrator.begin(model, m, h, state); });
  for (int i = 0; !integrator.is_solved(model, i, state); ++i) {
    each([&](int m) {
      if (iterates(model, m, i)) integrator.iterate(model, m, state);  // eqs 9-14
    });
    each([&](int m) { update_previous_iterate(state.muscles[m]); });
  }
  each([&](int m) { integrator.finish(model, m, h, state); });
  // In a loop of its own: finishing reads the other muscles, which this moves.
  each([&](int m) { blend_with_carried_shape(model, m, time, h, state.muscles[m]); });
}

// Substep i of bones and muscles. Returns a diagnosis if it failed.
std::optional<StepDiagnosis> step_muscles(const Model& model, const FrameDivision& division, int i,
                                          Parallel& parallel, State& state, StageSeconds& seconds) {
  const double time = division.time_after(i), h = division.step();
  StageClock clock(seconds.rig, parallel);
  drive_bones(model, time, state);
  choose_levels(model, h, state);
  drive_muscles(model, time, h, parallel, state);

  clock.enter(seconds.contact);
  update_colliders(model, state);
  if (auto tunnelling = find_tunnelling(model, state)) return tunnelling;
  find_all_contacts(model, parallel, state);

  clock.enter(seconds.muscles);
  solve_muscles(model, time, h, parallel, state);
  if (auto diagnosis = diagnose_step(model, h, state)) return diagnosis;  // before it is searched
  if (division.is_divided() || !part_muscles(model, parallel, state)) return {};
  return diagnose_step(model, h, state);
}

// The skin follows bones and muscles to `time` (s), and leaves props. Returns a diagnosis if it
// failed.
std::optional<StepDiagnosis> step_skin(const Model& model, double time, double share_of_return,
                                       Parallel& parallel, State& state, StageSeconds& seconds) {
  const StageClock clock(seconds.skin, parallel);
  refit_all(model, parallel, state);
  set_props(model, state);
  if (model.skinned) {
    set_felt(model, state, state.colliders);
    step_skinned(*model.skinned, state.bodies, state.colliders, parallel.loop(), state.layer,
                 state.skin, share_of_return, state.props);
  } else {
    set_colliders(model, state, state.colliders);
    state.colliders.resize(below_skin(model));
    carry_skin(model, time, state);
    step_skin(model.skin, state.pose, state.colliders, parallel.loop(), state.skin, share_of_return,
              state.props);
  }
  return diagnose_skin(model, state);
}

// All substeps of the frame, and the skin after some of them. Returns the diagnosis of the first
// that failed.
std::optional<StepDiagnosis> try_frame(const Model& model, const FrameDivision& division,
                                       Parallel& parallel, State& state, StageSeconds& seconds) {
  for (int i = 1; i <= division.substeps; ++i) {
    const auto substep = [&] { return step_muscles(model, division, i, parallel, state, seconds); };
    auto diagnosis = diagnose_solver(std::ref(substep));  // a std::function would allocate
    if (diagnosis) {
      diagnosis->substep = i;
      return diagnosis;
    }
    if (!model.has_skin || !division.steps_skin_after(i)) continue;
    if (auto of_skin = step_skin(model, division.time_after(i), kReturn, parallel, state, seconds))
      return of_skin;
  }
  return {};
}

void solve_frame(const Model& model, FrameDivision division, Parallel& parallel, State& state,
                 StageSeconds& seconds) {
  while (auto diagnosis = try_frame(model, division, parallel, state, seconds)) {
    undo_frame(model, state);
    if (!prepare_retry(model, *diagnosis, division, state)) {
      throw StepFailure(model, state.way ? state.way->clip_time : division.end, *diagnosis,
                        division.substeps);
    }
  }
  state.time = division.end;
}

}  // namespace

void step_frame(const Model& model, double time, Parallel& parallel, State& state,
                StageSeconds& seconds) {
  begin_frame(model, state);
  solve_frame(model, divide_frame(model, time, state), parallel, state, seconds);
}

void rest_frame(const Model& model, Parallel& parallel, State& state, StageSeconds& seconds) {
  begin_frame(model, state);
  solve_frame(model, divide_rest(model, state), parallel, state, seconds);
}

void rest_skin(const Model& model, double share_of_return, Parallel& parallel, State& state,
               StageSeconds& seconds) {
  if (const auto diagnosis =
          step_skin(model, state.time, share_of_return, parallel, state, seconds)) {
    const double clip_time = state.way ? state.way->clip_time : state.time;
    throw StepFailure(model, clip_time, *diagnosis, 1);
  }
}

}  // namespace thew::sim
