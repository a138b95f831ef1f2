// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/thew_cell.h"

#include <algorithm>
#include <cmath>

#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/solver/health.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tools/base/signals.h"

namespace thew::tools {
namespace {

constexpr double kMostWork = 3e7;  // nodes times substeps that an explicit cell may take

double energy_of(const Muscle& muscle, const MuscleState& now) {
  double energy = spring_energy(muscle.springs, now.rest_length, now.x);
  for (size_t i = 0; i < now.v.size(); ++i) {
    if (!muscle.driven[i]) energy += 0.5 * muscle.mass[i] * to_vec(now.v[i]).squaredNorm();
  }
  return energy;
}

Mechanism mechanism_of(Cause cause) {
  switch (cause) {
    case Cause::kDistance:
    case Cause::kSpeed:
      return Mechanism::kFliesOff;
    case Cause::kEdge:
      return Mechanism::kTorn;
    case Cause::kVolume:
    case Cause::kTurnedOver:
      return Mechanism::kTurnedOver;
    case Cause::kEnergy:
      return Mechanism::kEnergy;
    case Cause::kTunnelling:
    case Cause::kJump:
      return Mechanism::kTunnels;
    default:
      return Mechanism::kNoSolution;
  }
}

}  // namespace

const std::vector<ThewMethod>& thew_methods() {
  static const std::vector<double> kSteps = {0.0125, 0.025, 0.05, 0.1, 0.2};
  static const std::vector<ThewMethod> kAll = {{"local_global", 3, kSteps},
                                               {"xpbd", 10, kSteps},
                                               {"explicit", 1, kSteps},
                                               {"quasi_static", 1, {0.1, 0.2}}};
  return kAll;
}

ThewRun run_thew_cell(const MapBody& body, Load load, double value, const ThewMethod& method,
                      double h, bool rungs) {
  ThewRun run;
  MapCell& cell = run.cell;
  Model model = map_model(body, load, value);
  model.fps = 1.0 / h;
  model.solver.rungs = rungs;
  model.solver.integrator = integrator_of(method.integrator);
  model.solver.iterations = method.iterations;
  const Muscle& muscle = model.muscles[0];
  const int phase = static_cast<int>(std::lround(kPhase / h));
  if (model.solver.integrator == Integrator::kExplicit) {
    const double parts = stable_explicit_substeps(model, 0, h);
    if (parts * 4 * phase * static_cast<double>(muscle.mass.size()) > kMostWork) {
      cell.mechanism = Mechanism::kNotRun;
      cell.failure = "not run: " + std::to_string(std::lround(parts)) + " parts a step";
      return run;
    }
  }
  State state = initial_state(model);
  Parallel one(1);
  StageSeconds stages;
  CellWatch watch(muscle.rest.triangles, muscle.rest_volume, phase);
  Rung highest = Rung::kNone;
  try {
    for (int frame = 1; frame <= 4 * phase; ++frame) {
      stop_if_interrupted();
      if (rungs && stands_alone(model)) {
        solve_lone_frame(model, frame * h, one, state, stages, [] { stop_if_interrupted(); });
      } else {
        step_frame(model, frame * h, one, state, stages);
      }
      const MuscleState& now = state.muscles[0];
      watch.see(frame, now.x, energy_of(muscle, now), cell);
      highest = std::max(highest, now.ladder.frame_rung);
    }
  } catch (const StepFailure& failure) {
    cell.failure = failure.what();
    cell.mechanism = mechanism_of(failure.diagnosis.cause);
    cell.verdict = Verdict::kDiverged;
    return run;
  }
  for (const Point& v : state.muscles[0].v) {
    cell.speed = std::max(cell.speed, to_vec(v).norm() / body.size.norm());
  }
  run.last = state.muscles[0].x;
  run.rung = kRungs[static_cast<int>(highest)];
  return run;
}

}  // namespace thew::tools
