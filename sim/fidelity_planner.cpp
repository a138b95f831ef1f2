// SPDX-License-Identifier: Apache-2.0
#include "sim/fidelity_planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "sim/drive.h"
#include "sim/fidelity_probes.h"
#include "sim/step.h"

namespace thew {
namespace {

constexpr int kReferenceSubsteps = 8, kReferenceIterations = 10;
constexpr int kIterations[] = {1, 2, 3, 5, 8};
constexpr int kMostSubsteps = 4;  // half of the reference's, of which they are judged
// Of the tolerance: in the probes and in checks of some frames, since others may be worse; in checks
// of all, since the reference itself is not the limit.
constexpr double kMargin = 0.8, kCheckMargin = 0.9, kWholeMargin = 0.97;
constexpr double kApart = 0.02;   // of the range of a path's length: knots are not closer
constexpr int kMostRuns = 12;
// Frames of a clip that is refined as a whole, since probes and checks would cost as much.
constexpr int kShortClip = 128;

Fidelity uniform(const Model& model, int substeps, Level level, int iterations) {
  Fidelity all;
  all.substeps = substeps;
  all.muscles.assign(model.muscles.size(), {level, iterations, {}});
  return all;
}

double distance(const Rows& a, const Rows& b) {
  double squared = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Row d = a[i] - b[i];
    squared = std::max(squared, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  }
  return std::sqrt(squared);
}

std::string millimetres(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

// What a run has done: work by muscle, in nodes and searches.
std::vector<double> work_of(const State& state) {
  std::vector<double> work;
  for (const MuscleState& muscle : state.muscles) {
    work.push_back(static_cast<double>(muscle.node_iterations + muscle.memory.searches));
  }
  return work;
}

// The frames before a probe, and the probe: from a state of the coarse run.
struct Window {
  int frame = 0;              // the probe
  std::vector<double> before; // packed, at frame - kBefore or the first
  std::vector<Rows> x;        // of the reference, by muscle
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
  std::vector<Window> windows;  // by frame
  std::set<int> checks;         // of them, those that are no probes
  std::vector<Trial> trials = {};
  FidelityPlan plan = {};

  int muscles() const { return static_cast<int>(model.muscles.size()); }
  double time_of(int frame) const { return frame / model.scene.fps; }  // frames counted from 0
  bool is_check(const Window& window) const { return checks.count(window.frame) > 0; }

  void hear() const {
    if (listen) listen();
  }
};

// From the window's start to its probe; the frames' work is added up.
State run_window(const Planner& planner, const Window& window, double& frames) {
  Parallel one(1);
  StageSeconds unused;
  State state;
  unpack_state(planner.model, window.before, state);
  const int first = static_cast<int>(std::lround(state.time * planner.model.scene.fps));
  for (int frame = first + 1; frame <= window.frame; ++frame, ++frames) {
    planner.hear();
    step_frame(planner.model, planner.time_of(frame), one, state, unused);
  }
  return state;
}

// Through the whole clip. on_frame(frame, state): frames counted from 0.
template <typename OnFrame>
State run_clip(Planner& planner, int last, const OnFrame& on_frame) {
  StageSeconds unused;
  State state = initial_state(planner.model);
  settle(planner.model, planner.parallel, state, planner.listen);
  for (MuscleState& muscle : state.muscles) muscle.node_iterations = muscle.memory.searches = 0;
  on_frame(0, state);
  for (int frame = 1; frame <= last; ++frame) {
    planner.hear();
    step_frame(planner.model, planner.time_of(frame), planner.parallel, state, unused);
    on_frame(frame, state);
  }
  return state;
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

void keep(const State& state, Window& window) {
  for (const MuscleState& muscle : state.muscles) {
    window.x.push_back(muscle.x);
    window.pose.push_back(muscle.pose);
  }
}

// A short clip: the refined step through all of it.
void refine_clip(Planner& planner, const Fidelity& fine) {
  planner.model.fidelity = fine;
  const State end = run_clip(planner, planner.windows.back().frame, [&](int frame, const State& state) {
    for (Window& window : planner.windows) {
      const bool begins = std::max(window.frame - kFramesBefore, 0) == frame;
      if (begins && !planner.is_check(window)) window.before = pack_state(state);
      if (window.frame == frame) keep(state, window);
    }
  });
  planner.plan.probe_work += sum(work_of(end));
}

// A long one: a plain step through it, refined in the few frames up to each probe and check.
void refine_windows(Planner& planner, const Fidelity& fine) {
  planner.model.fidelity = uniform(planner.model, 1, Level::kDynamic, 2);
  const State end = run_clip(planner, planner.windows.back().frame, [&](int frame, const State& state) {
    for (Window& window : planner.windows) {
      if (std::max(window.frame - kFramesBefore, 0) == frame) window.before = pack_state(state);
    }
  });
  planner.plan.probe_work += sum(work_of(end));
  planner.model.fidelity = fine;
  const int count = static_cast<int>(planner.windows.size());
  std::vector<double> work(count);
  planner.parallel.each(count, [&](int w) {
    double frames = 0.0;
    const State state = run_window(planner, planner.windows[w], frames);
    keep(state, planner.windows[w]);
    work[w] = sum(work_of(state));
  });
  planner.plan.probe_work += sum(work);
}

void run_trial(Planner& planner, Trial trial) {
  planner.model.fidelity =
      uniform(planner.model, trial.substeps, trial.level, trial.iterations);
  const int count = static_cast<int>(planner.windows.size());
  std::vector<std::vector<double>> errors(count), work(count);
  std::vector<double> frames(count, 0.0);
  planner.parallel.each(count, [&](int w) {
    const Window& window = planner.windows[w];
    if (planner.is_check(window)) return;
    const State state = run_window(planner, window, frames[w]);
    for (int m = 0; m < state.count(); ++m) {
      errors[w].push_back(distance(state.muscles[m].x, window.x[m]));
    }
    work[w] = work_of(state);
  });
  trial.error.assign(planner.muscles(), 0.0);
  trial.work.assign(planner.muscles(), 0.0);
  for (int w = 0; w < count; ++w) {
    for (size_t m = 0; m < errors[w].size(); ++m) {
      trial.error[m] = std::max(trial.error[m], errors[w][m]);
      trial.work[m] += work[w][m] / sum(frames);
      planner.plan.probe_work += work[w][m];
    }
  }
  planner.trials.push_back(std::move(trial));
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
  MuscleState placed;
  const bool reached = place_carried(muscle, probe.pose[m], profile, placed);
  return reached ? distance(placed.x, probe.x[m]) : 1e300;
}

// A profile through as few probes as keep the tolerance in the others and, since these may lie close
// to knots, in each inner knot by half without itself (the error goes with the square of the knots'
// distance). False where there is none; `error` is then the least that was found.
bool fit_profile(const Planner& planner, int m, CarriedProfile& profile, double& error) {
  const Muscle& muscle = planner.model.muscles[m];
  if (!muscle.shape.held.empty()) return false;  // no axis to be carried along
  Knots probes;
  for (const Window& window : planner.windows) {
    if (!planner.is_check(window)) probes.push_back(&window);
  }
  if (probes.empty()) return false;
  const auto change = [&](const Window* window) { return window->pose[m].change; };
  const auto less = [&](const Window* a, const Window* b) { return change(a) < change(b); };
  const auto [shortest, longest] = std::minmax_element(probes.begin(), probes.end(), less);
  const double apart = kApart * (change(*longest) - change(*shortest));
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
      const double here =
          profile_error(muscle, m, profile_through(muscle, m, others), *knots[k]);
      most = std::max(most, 0.5 * here);
    }
    if (most < error) error = most, profile = std::move(through);
    if (error <= kMargin * planner.tolerance) return true;
    if (!next) return false;
    knots.insert(std::upper_bound(knots.begin(), knots.end(), next, less), next);
  }
}

std::string text_of(const MuscleFidelity& muscle) {
  std::string text = level_name(muscle.level);
  if (muscle.level == Level::kGeometric) {
    const size_t knots = muscle.profile.change.size();
    return text + " with a profile of " + std::to_string(knots) + (knots == 1 ? " knot" : " knots");
  }
  return text + " with " + std::to_string(muscle.iterations) +
         (muscle.iterations == 1 ? " iteration" : " iterations");
}

// The first trial with so many substeps, in their order of cost, that keeps muscle m.
const Trial* find_trial(const Planner& planner, int m, int substeps) {
  for (const Trial& trial : planner.trials) {
    if (trial.substeps == substeps && trial.error[m] <= kMargin * planner.tolerance) {
      return &trial;
    }
  }
  return nullptr;
}

[[noreturn]] void refuse_tolerance(const Planner& planner, const std::string& why) {
  throw Error(ExitCode::kUsage, planner.model.scene.solver.tolerance->place +
                                    ": solver.tolerance: " + why +
                                    "; give a larger tolerance, or integrator and substeps");
}

// Trials at rising cost until each muscle is kept by one; leaves in the plan how many substeps.
void run_trials(Planner& planner, const std::vector<char>& is_geometric) {
  for (int substeps = 1; substeps <= kMostSubsteps; substeps *= 2) {
    bool all_alike = false;
    for (const int iterations : kIterations) {
      for (const Level level : {Level::kDynamic, Level::kQuasiStatic}) {
        run_trial(planner, {substeps, iterations, level, {}, {}});
        const Trial& trial = planner.trials.back();
        bool all = true;
        for (const double error : trial.error) all &= error <= kMargin * planner.tolerance;
        planner.plan.uniform_keeps = all;
        planner.plan.uniform_substeps = substeps;
        planner.plan.uniform_iterations = iterations;
        planner.plan.uniform_work = sum(trial.work);
        for (int m = 0; m < planner.muscles(); ++m) {
          planner.plan.muscles[m].uniform_work = trial.work[m];
        }
        all_alike = all;
        if (all) break;
      }
      if (all_alike) break;
    }
    bool all = true;
    for (int m = 0; m < planner.muscles(); ++m) {
      all &= is_geometric[m] || find_trial(planner, m, substeps);
    }
    planner.plan.fidelity.substeps = substeps;
    if (all) return;
  }
  std::string worst;
  double error = -1.0;
  for (int m = 0; m < planner.muscles(); ++m) {
    if (is_geometric[m] || !(planner.trials.back().error[m] > error)) continue;
    error = planner.trials.back().error[m];
    worst = planner.model.muscles[m].name;
  }
  refuse_tolerance(planner, "no level keeps muscle \"" + worst + "\" within it: the finest is " +
                                millimetres(error) + " off the refined step");
}

void choose(Planner& planner) {
  std::vector<char> is_geometric;
  std::vector<double> geometric_error;
  std::vector<CarriedProfile> profiles(planner.muscles());
  for (int m = 0; m < planner.muscles(); ++m) {
    is_geometric.push_back(
        fit_profile(planner, m, profiles[m], geometric_error.emplace_back(0.0)));
  }
  run_trials(planner, is_geometric);
  Fidelity& fidelity = planner.plan.fidelity;
  fidelity.rest = 1e-3 * planner.tolerance;
  for (int m = 0; m < planner.muscles(); ++m) {
    MuscleFidelity& muscle = fidelity.muscles.emplace_back();
    ChosenMuscle& said = planner.plan.muscles[m];
    if (is_geometric[m]) {
      muscle = {Level::kGeometric, 0, std::move(profiles[m])};
      said.because = "the carried shape is within " + millimetres(geometric_error[m]);
      continue;
    }
    const Trial& trial = *find_trial(planner, m, fidelity.substeps);
    muscle = {trial.level, trial.iterations, {}};
    const bool has_axis = planner.model.muscles[m].shape.held.empty();
    said.because = has_axis ? "the carried shape is " + millimetres(geometric_error[m]) + " off"
                            : std::string("it has no axis to be carried along");
    if (&trial != &planner.trials.front()) {
      const Trial& before = *(&trial - 1);
      said.because += ", " + text_of({before.level, before.iterations, {}}) + " " +
                      millimetres(before.error[m]) + " off";
    }
    said.because += ", this " + millimetres(trial.error[m]);
  }
}

// The next level of a muscle that missed, with inertia; more substeps for all where it has no other.
// False where there are none.
bool raise(Planner& planner, int m, double error, bool in_check) {
  Fidelity& fidelity = planner.plan.fidelity;
  MuscleFidelity& muscle = fidelity.muscles[m];
  const std::string before = text_of(muscle);
  const int more = muscle.level == Level::kGeometric     ? 1
                   : muscle.level == Level::kQuasiStatic ? muscle.iterations
                                                         : muscle.iterations + 1;
  const auto next = std::lower_bound(std::begin(kIterations), std::end(kIterations), more);
  if (next == std::end(kIterations)) {
    if (fidelity.substeps == kMostSubsteps) return false;
    fidelity.substeps *= 2;
  } else {
    const auto keeps = [&](const Trial& trial) {
      return trial.level == Level::kDynamic && trial.substeps == fidelity.substeps &&
             trial.iterations >= more && trial.error[m] <= kMargin * planner.tolerance;
    };
    const auto trial = std::find_if(planner.trials.begin(), planner.trials.end(), keeps);
    muscle = {Level::kDynamic, trial == planner.trials.end() ? *next : trial->iterations, {}};
  }
  const std::string what =
      planner.model.muscles[m].name + " was " + millimetres(error) + " off in a " +
      (in_check ? "checked" : "probed") + " frame, " + before + "; now " + text_of(muscle) +
      (fidelity.substeps > 1 ? ", " + std::to_string(fidelity.substeps) + " substeps a frame" : "");
  planner.plan.muscles[m].because += "; " + what;
  planner.plan.raised.push_back(what);
  return true;
}

// The choice through the whole clip: its errors in probes and checks. Whether all keep to it.
bool rehearse(Planner& planner, int last) {
  planner.model.fidelity = planner.plan.fidelity;
  std::vector<ChosenMuscle>& said = planner.plan.muscles;
  std::vector<int> slept(planner.muscles(), 0);
  double volume_error = 0.0;
  for (ChosenMuscle& muscle : said) muscle.probed_error = muscle.checked_error = 0.0;
  const State end = run_clip(planner, last, [&](int frame, const State& state) {
    for (int m = 0; m < state.count(); ++m) {
      slept[m] += frame > 0 && state.muscles[m].level == Level::kAsleep;
      volume_error = std::max(volume_error, state.muscles[m].volume_error);
    }
    for (const Window& window : planner.windows) {
      if (window.frame != frame) continue;
      for (int m = 0; m < state.count(); ++m) {
        const double error = distance(state.muscles[m].x, window.x[m]);
        double& most = planner.is_check(window) ? said[m].checked_error : said[m].probed_error;
        most = std::max(most, error);
      }
    }
  });
  const std::vector<double> work = work_of(end);
  planner.plan.probe_work += sum(work);
  planner.plan.work = sum(work) / std::max(last, 1);
  for (int m = 0; m < planner.muscles(); ++m) {
    const MuscleFidelity& chosen = planner.plan.fidelity.muscles[m];
    said[m].level = last > 0 && slept[m] == last ? Level::kAsleep : chosen.level;
    said[m].iterations = has_forces(chosen.level) ? chosen.iterations : 0;
    said[m].work = work[m] / std::max(last, 1);
  }
  if (volume_error > planner.model.scene.solver.tolerance->volume) {
    char found[60];
    std::snprintf(found, sizeof found, "the volume is off by %.3g of 1", volume_error);
    refuse_tolerance(planner, found);
  }
  bool all = true;
  for (int m = 0; m < planner.muscles(); ++m) {
    const double error = std::max(said[m].probed_error, said[m].checked_error);
    if (error <= (last <= kShortClip ? kWholeMargin : kCheckMargin) * planner.tolerance) continue;
    if (raise(planner, m, error, said[m].checked_error > said[m].probed_error)) {
      all = false;
    } else if (error > planner.tolerance) {
      refuse_tolerance(planner, "muscle \"" + planner.model.muscles[m].name + "\" is " +
                                    millimetres(error) + " off the refined step at the finest level");
    }
  }
  return all;
}

}  // namespace

const char* level_name(Level level) {
  switch (level) {
    case Level::kAsleep: return "asleep";
    case Level::kGeometric: return "geometric";
    case Level::kQuasiStatic: return "quasi_static";
    case Level::kDynamic: break;
  }
  return "dynamic";
}

FidelityPlan plan_fidelity(const Model& model, int threads,
                           const std::function<void()>& listen) {
  Parallel parallel(threads);
  Planner planner{model, parallel, listen, model.scene.solver.tolerance->position, {}, {}};
  Scene& scene = planner.model.scene;
  planner.model.has_skin = false;
  planner.model.skinned.reset();
  const int last = scene.last_frame - scene.first_frame;
  if (last < 1) refuse_tolerance(planner, "one frame has no motion to probe");
  ProbeFrames frames = choose_probes(model);
  if (last <= kShortClip) {
    frames.checks.clear();
    for (int frame = 1; frame <= last; ++frame) frames.checks.push_back(frame);
  }
  planner.checks.insert(frames.checks.begin(), frames.checks.end());
  for (const int frame : frames.probes) planner.checks.erase(frame);
  std::set<int> all = planner.checks;
  all.insert(frames.probes.begin(), frames.probes.end());
  for (const int frame : all) planner.windows.push_back({frame, {}, {}, {}});
  for (const int frame : frames.probes) planner.plan.probed.push_back(scene.first_frame + frame);
  for (const int frame : planner.checks) planner.plan.checked.push_back(scene.first_frame + frame);
  planner.plan.muscles.resize(planner.muscles());
  const Fidelity fine =
      uniform(planner.model, kReferenceSubsteps, Level::kDynamic, kReferenceIterations);
  if (last <= kShortClip) {
    refine_clip(planner, fine);
  } else {
    refine_windows(planner, fine);
  }
  choose(planner);
  for (int run = 1; !rehearse(planner, last); ++run) {
    if (run == kMostRuns) refuse_tolerance(planner, "no choice kept it in " + std::to_string(run) + " runs");
  }
  return std::move(planner.plan);
}

}  // namespace thew
