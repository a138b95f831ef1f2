// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <set>

#include "sim/fidelity/plan.h"
#include "sim/fidelity/probes.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::sim {

// The planner's runs in probes: of the refined step, and of all muscles at one level.

// Share of the tolerance that an error in the probes may reach, since other frames may be worse.
inline constexpr double kMargin = 0.8;
// Frames. A clip of no more is refined as a whole, since probes and checks would cost as much.
inline constexpr int kShortClip = 128;

// A probe or check with the frames before it, and what the refined step comes to in it.
struct Window {
  int frame = 0;               // the probe or check
  std::vector<double> before;  // packed state, kFramesBefore before the frame or at the first
  std::vector<Points> x;       // [muscle] of the refined step
  std::vector<CarriedPose> pose;
};

// One level, substeps and iterations for all muscles, and its errors and work in the probes.
struct Trial {
  int substeps = 1, iterations = 1;
  Level level = Level::kDynamic;
  std::vector<double> error, work;  // [muscle] m, the largest error; work per frame
};

struct Planner {
  Model model;  // whose fidelity changes from run to run
  Parallel& parallel;
  const std::function<void()>& check_stop;
  double tolerance = 0.0;
  int last = 0;                      // frame
  std::vector<Window> windows = {};  // by frame
  std::set<int> checks = {};         // frames of the windows that are no probes
  std::vector<Trial> trials = {};
  FidelityPlan plan = {};

  // m, the tolerance without the refined step's own error.
  double remaining(int m) const { return tolerance - plan.muscles[m].refined_error; }
  int muscles() const { return static_cast<int>(model.muscles.size()); }
  double time_of(int frame) const { return frame / model.fps; }  // frames counted from 0
  bool is_check(const Window& window) const { return checks.count(window.frame) > 0; }

  void poll() const {
    if (check_stop) check_stop();
  }
};

/// The same level and iterations for all muscles. None sleeps, since still_distance is negative.
Fidelity uniform(const Model& model, int substeps, Level level, int iterations);
double sum(const std::vector<double>& values);
/// [muscle] nodes times iterations plus searches, since the run began.
std::vector<double> work_of(const State& state);

// Simulates the whole clip. on_frame(frame, state) is called after each frame, counted from 0.
template <typename OnFrame>
State run_clip(Planner& planner, const OnFrame& on_frame) {
  StageSeconds unused;
  State state = initial_state(planner.model);
  settle(planner.model, planner.parallel, state, planner.check_stop);
  for (MuscleState& muscle : state.muscles) muscle.node_iterations = muscle.memory.searches = 0;
  on_frame(0, state);
  for (int frame = 1; frame <= planner.last; ++frame) {
    planner.poll();
    step_frame(planner.model, planner.time_of(frame), planner.parallel, state, unused);
    on_frame(frame, state);
  }
  return state;
}

/// Runs the refined step in all windows. Its own error is the difference to half as many substeps.
void find_references(Planner& planner);
/// Runs a trial in the probes and adds it to planner.trials with its errors and work.
void run_trial(Planner& planner, Trial trial);
/// Fits a profile through as few probes, its knots, as keep the tolerance in the other probes.
/// These may lie close to knots, so each inner knot is also left out in turn; half of the error in
/// it counts, since the error goes with the square of the knots' distance. False where no profile
/// keeps the tolerance or the muscle has no path; `error` (m) is the least that was found.
bool fit_profile(const Planner& planner, int m, CarriedProfile& profile, double& error);

}  // namespace thew::sim
