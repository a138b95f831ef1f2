// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <set>

#include "sim/fidelity/plan.h"
#include "sim/fidelity/probes.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::sim {

// The planner's runs: the refined step, and all muscles alike at one level, in probes.

// Of the tolerance, in the probes: other frames may be worse.
inline constexpr double kMargin = 0.8;
// Frames of a clip that is refined as a whole, since probes and checks would cost as much.
inline constexpr int kShortClip = 128;

// The frames before a probe, and the probe: from a state of the coarse run.
struct Window {
  int frame = 0;               // the probe
  std::vector<double> before;  // packed, at frame - kBefore or the first
  std::vector<Points> x;       // of the reference, by muscle
  std::vector<CarriedPose> pose;
};

// A way to simulate all muscles alike, and what it came to in the probes.
struct Trial {
  int substeps = 1, iterations = 1;
  Level level = Level::kDynamic;
  std::vector<double> error, work;  // by muscle; work a frame
};

struct Planner {
  Model model;  // whose fidelity changes from run to run
  Parallel& parallel;
  const std::function<void()>& listen;
  double tolerance = 0.0;
  int last = 0;                      // frame
  std::vector<Window> windows = {};  // by frame
  std::set<int> checks = {};         // of them, those that are no probes
  std::vector<Trial> trials = {};
  FidelityPlan plan = {};

  // m, what the refined step leaves of the tolerance.
  double left(int m) const { return tolerance - plan.muscles[m].refined_error; }
  int muscles() const { return static_cast<int>(model.muscles.size()); }
  double time_of(int frame) const { return frame / model.fps; }  // frames counted from 0
  bool is_check(const Window& window) const { return checks.count(window.frame) > 0; }

  void hear() const {
    if (listen) listen();
  }
};

/// All muscles alike; none sleeps.
Fidelity uniform(const Model& model, int substeps, Level level, int iterations);
double sum(const std::vector<double>& values);
/// By muscle, in nodes and searches, since the run began.
std::vector<double> work_of(const State& state);

// Through the whole clip. on_frame(frame, state): frames counted from 0.
template <typename OnFrame>
State run_clip(Planner& planner, const OnFrame& on_frame) {
  StageSeconds unused;
  State state = initial_state(planner.model);
  settle(planner.model, planner.parallel, state, planner.listen);
  for (MuscleState& muscle : state.muscles) muscle.node_iterations = muscle.memory.searches = 0;
  on_frame(0, state);
  for (int frame = 1; frame <= planner.last; ++frame) {
    planner.hear();
    step_frame(planner.model, planner.time_of(frame), planner.parallel, state, unused);
    on_frame(frame, state);
  }
  return state;
}

/// The refined step in all windows; its own error is taken from half as many substeps.
void find_references(Planner& planner);
/// Adds it to planner.trials with its errors and work in the probes.
void run_trial(Planner& planner, Trial trial);
/// A profile through as few probes as keep the tolerance in the others and, since these may lie
/// close to knots, in each inner knot by half without itself (the error goes with the square of the
/// knots' distance). False where there is none; `error` is then the least that was found.
bool fit_profile(const Planner& planner, int m, CarriedProfile& profile, double& error);

}  // namespace thew::sim
