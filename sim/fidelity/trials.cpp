// SPDX-License-Identifier: Apache-2.0
#include "sim/fidelity/trials.h"

#include <algorithm>

#include "sim/solver/levels.h"
#include "sim/solver/state_archive.h"

namespace thew::sim {
namespace {

// Of the refined step: the finest setting of the charts (thew-lab).
constexpr int kReferenceSubsteps = 8, kReferenceIterations = 10;
constexpr double kMinKnotDistance = 0.02;  // of the range of a path's length: knots are not closer

// Simulates a window from its packed state to its frame. Adds the frames that it stepped to
// `frames`.
State run_window(const Planner& planner, const Window& window, double& frames) {
  Parallel one(1);
  StageSeconds unused;
  State state;
  unpack_state(planner.model, window.before, state);
  forget_searches(state);  // otherwise the work of a level would depend on the run before
  const int first = static_cast<int>(std::lround(state.time * planner.model.fps));
  for (int frame = first + 1; frame <= window.frame; ++frame, ++frames) {
    planner.poll();
    step_frame(planner.model, planner.time_of(frame), one, state, unused);
  }
  return state;
}

void keep(const State& state, Window& window) {
  for (const MuscleState& muscle : state.muscles) {
    window.x.push_back(muscle.x);
    window.pose.push_back(muscle.pose);
  }
}

// A short clip is refined as a whole. Calls on_window(window, state) at each window's frame.
template <typename OnWindow>
void refine_clip(Planner& planner, const Fidelity& fine, const OnWindow& on_window) {
  planner.model.fidelity = fine;
  const State end = run_clip(planner, [&](int frame, const State& state) {
    for (Window& window : planner.windows) {
      const bool begins = std::max(window.frame - kFramesBefore, 0) == frame;
      if (begins && !planner.is_check(window) && window.x.empty()) {
        window.before = pack_state(state);
      }
      if (window.frame == frame) on_window(window, state);
    }
  });
  planner.plan.probe_work += sum(work_of(end));
}

// A long clip is run once with a coarse step; only the frames of each window are refined
// afterwards.
void run_up_to_windows(Planner& planner) {
  planner.model.fidelity = uniform(planner.model, 1, Level::kDynamic, 2);
  const State end = run_clip(planner, [&](int frame, const State& state) {
    for (Window& window : planner.windows) {
      if (std::max(window.frame - kFramesBefore, 0) == frame) window.before = pack_state(state);
    }
  });
  planner.plan.probe_work += sum(work_of(end));
}

template <typename OnWindow>
void refine_windows(Planner& planner, const Fidelity& fine, const OnWindow& on_window) {
  planner.model.fidelity = fine;
  const int count = static_cast<int>(planner.windows.size());
  std::vector<State> states(count);
  planner.parallel.each(count, [&](int w) {
    double frames = 0.0;
    states[w] = run_window(planner, planner.windows[w], frames);
  });
  for (int w = 0; w < count; ++w) {
    on_window(planner.windows[w], states[w]);
    planner.plan.probe_work += sum(work_of(states[w]));
  }
}

using Knots = std::vector<const Window*>;

CarriedProfile profile_through(const Muscle& muscle, int m, const Knots& knots) {
  CarriedProfile profile;
  for (const Window* knot : knots) {
    profile.change.push_back(knot->pose[m].change);
    profile.offset.push_back(
        profile_offsets(muscle.shape, knot->pose[m], muscle.swells, knot->x[m]));
  }
  return profile;
}

double profile_error(const Muscle& muscle, int m, const CarriedProfile& profile,
                     const Window& probe) {
  VolumeWork work;
  Points x;
  const bool reached = set_carried_shape(muscle, probe.pose[m], profile, work, x);
  return reached ? largest_distance(x, probe.x[m]) : 1e300;
}

}  // namespace

Fidelity uniform(const Model& model, int substeps, Level level, int iterations) {
  Fidelity all;
  all.substeps = substeps;
  all.muscles.assign(model.muscles.size(), {level, iterations, {}});
  return all;
}

std::vector<double> work_of(const State& state) {
  std::vector<double> work;
  for (const MuscleState& muscle : state.muscles) {
    work.push_back(static_cast<double>(muscle.node_iterations + muscle.memory.searches +
                                       muscle.face_memory.searches));
  }
  return work;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

void find_references(Planner& planner) {
  const bool is_short = planner.last <= kShortClip;
  const auto refine = [&](int substeps, const auto& on_window) {
    const Fidelity fine = uniform(planner.model, substeps, Level::kDynamic, kReferenceIterations);
    if (is_short) {
      refine_clip(planner, fine, on_window);
    } else {
      refine_windows(planner, fine, on_window);
    }
  };
  if (!is_short) run_up_to_windows(planner);
  refine(kReferenceSubsteps, [](Window& window, const State& state) { keep(state, window); });
  refine(kReferenceSubsteps / 2, [&](const Window& window, const State& state) {
    for (int m = 0; m < state.count(); ++m) {
      double& error = planner.plan.muscles[m].refined_error;
      error = std::max(error, largest_distance(state.muscles[m].x, window.x[m]));
    }
  });
}

void run_trial(Planner& planner, Trial trial) {
  planner.model.fidelity = uniform(planner.model, trial.substeps, trial.level, trial.iterations);
  const int count = static_cast<int>(planner.windows.size());
  std::vector<std::vector<double>> errors(count), work(count);
  std::vector<double> frames(count, 0.0);
  planner.parallel.each(count, [&](int w) {
    const Window& window = planner.windows[w];
    if (planner.is_check(window)) return;
    const State state = run_window(planner, window, frames[w]);
    for (int m = 0; m < state.count(); ++m) {
      errors[w].push_back(largest_distance(state.muscles[m].x, window.x[m]));
    }
    work[w] = work_of(state);
  });
  trial.error.assign(planner.muscles(), 0.0);
  trial.work.assign(planner.muscles(), 0.0);
  const double stepped = std::max(sum(frames), 1.0);  // windows at the first frame step none
  for (int w = 0; w < count; ++w) {
    for (size_t m = 0; m < errors[w].size(); ++m) {
      trial.error[m] = std::max(trial.error[m], errors[w][m]);
      trial.work[m] += work[w][m] / stepped;
      planner.plan.probe_work += work[w][m];
    }
  }
  planner.trials.push_back(std::move(trial));
}

bool fit_profile(const Planner& planner, int m, CarriedProfile& profile, double& error) {
  const Muscle& muscle = planner.model.muscles[m];
  if (!muscle.shape.fixed_to.empty()) return false;  // no axis to be carried along
  Knots probes;
  for (const Window& window : planner.windows) {
    if (!planner.is_check(window)) probes.push_back(&window);
  }
  if (probes.empty()) return false;
  const auto change = [&](const Window* window) { return window->pose[m].change; };
  const auto less = [&](const Window* a, const Window* b) { return change(a) < change(b); };
  const auto [shortest, longest] = std::minmax_element(probes.begin(), probes.end(), less);
  const double apart = kMinKnotDistance * (change(*longest) - change(*shortest));
  Knots knots = {*shortest};
  if (change(*longest) > change(*shortest)) knots.push_back(*longest);
  error = 1e300;
  while (true) {
    CarriedProfile through = profile_through(muscle, m, knots);
    double most = 0.0, worst = -1.0;
    const Window* next = nullptr;
    for (const Window* probe : probes) {
      const double here = profile_error(muscle, m, through, *probe);
      most = std::max(most, here);
      const bool is_new = std::none_of(knots.begin(), knots.end(), [&](const Window* knot) {
        return std::abs(change(knot) - change(probe)) <= apart;
      });
      if (is_new && here > worst) worst = here, next = probe;
    }
    for (size_t k = 1; k + 1 < knots.size(); ++k) {
      Knots others = knots;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      const double here = profile_error(muscle, m, profile_through(muscle, m, others), *knots[k]);
      most = std::max(most, 0.5 * here);
    }
    if (most < error) error = most, profile = std::move(through);
    if (error <= kMargin * planner.remaining(m)) return true;
    if (!next) return false;
    knots.insert(std::upper_bound(knots.begin(), knots.end(), next, less), next);
  }
}

}  // namespace thew::sim
