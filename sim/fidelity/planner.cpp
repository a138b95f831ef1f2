// SPDX-License-Identifier: Apache-2.0
#include "sim/fidelity/planner.h"

#include <algorithm>
#include <cstdio>

#include "sim/fidelity/trials.h"

namespace thew::sim {
namespace {

constexpr int kIterations[] = {1, 2, 3, 5, 8};  // that are tried, per step
constexpr int kMostSubsteps = 4;  // half of the refined step's, which they are measured against
// Shares of the tolerance that an error may reach: where some frames are checked, since others may
// be worse, and where all are.
constexpr double kCheckMargin = 0.9, kWholeMargin = 0.97;
constexpr int kMaxRuns = 12;  // of the whole clip, each with a finer choice

std::string millimetres(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
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

// The cheapest trial with so many substeps that keeps muscle m within the tolerance; null: none.
const Trial* find_trial(const Planner& planner, int m, int substeps) {
  for (const Trial& trial : planner.trials) {
    if (trial.substeps == substeps && trial.error[m] <= kMargin * planner.remaining(m)) {
      return &trial;
    }
  }
  return nullptr;
}

[[noreturn]] void refuse_tolerance(const Planner& planner, const std::string& why) {
  throw Error(ErrorCode::kUsage, planner.model.solver.tolerance->location + ": solver.tolerance: " +
                                     why + "; give a larger tolerance, or integrator and substeps");
}

void refuse_unknown(const Planner& planner) {
  for (int m = 0; m < planner.muscles(); ++m) {
    if (planner.remaining(m) > 0.0) continue;
    refuse_tolerance(planner, "of muscle \"" + planner.model.muscles[m].name +
                                  "\" the refined step itself is known to " +
                                  millimetres(planner.plan.muscles[m].refined_error) + " only");
  }
}

// Runs trials in the order of their cost until each muscle has a level. Sets the plan's substeps.
void run_trials(Planner& planner, const std::vector<char>& is_geometric) {
  int& substeps = planner.plan.fidelity.substeps;
  for (substeps = 1; substeps <= kMostSubsteps; substeps *= 2) {
    for (const int iterations : kIterations) {
      for (const Level level : {Level::kDynamic, Level::kQuasiStatic}) {
        bool all = true;
        for (int m = 0; m < planner.muscles(); ++m) {
          all = all && (is_geometric[m] || find_trial(planner, m, substeps));
        }
        if (all) return;
        run_trial(planner, {substeps, iterations, level, {}, {}});
      }
    }
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
    is_geometric.push_back(fit_profile(planner, m, profiles[m], geometric_error.emplace_back(0.0)));
  }
  run_trials(planner, is_geometric);
  Fidelity& fidelity = planner.plan.fidelity;
  fidelity.still_distance = 1e-3 * planner.tolerance;
  for (int m = 0; m < planner.muscles(); ++m) {
    MuscleFidelity& muscle = fidelity.muscles.emplace_back();
    ChosenMuscle& chosen = planner.plan.muscles[m];
    if (is_geometric[m]) {
      muscle = {Level::kGeometric, 0, std::move(profiles[m])};
      chosen.reason = "the carried shape is within " + millimetres(geometric_error[m]);
      continue;
    }
    const Trial& trial = *find_trial(planner, m, fidelity.substeps);
    muscle = {trial.level, trial.iterations, {}};
    const bool has_axis = planner.model.muscles[m].shape.fixed_to.empty();
    chosen.reason = has_axis ? "the carried shape is " + millimetres(geometric_error[m]) + " off"
                             : std::string("it has no axis to be carried along");
    if (&trial != &planner.trials.front()) {
      const Trial& before = *(&trial - 1);
      chosen.reason += ", " + text_of({before.level, before.iterations, {}}) + " " +
                       millimetres(before.error[m]) + " off";
    }
    chosen.reason += ", this " + millimetres(trial.error[m]);
  }
}

// Gives a muscle that missed the tolerance its next level with inertia, or all muscles more
// substeps where it has no other. False where there are none either.
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
             trial.iterations >= more && trial.error[m] <= kMargin * planner.remaining(m);
    };
    const auto trial = std::find_if(planner.trials.begin(), planner.trials.end(), keeps);
    muscle = {Level::kDynamic, trial == planner.trials.end() ? *next : trial->iterations, {}};
  }
  const std::string what =
      planner.model.muscles[m].name + " was " + millimetres(error) + " off in a " +
      (in_check ? "checked" : "probed") + " frame, " + before + "; now " + text_of(muscle) +
      (fidelity.substeps > 1 ? ", " + std::to_string(fidelity.substeps) + " substeps a frame" : "");
  planner.plan.muscles[m].reason += "; " + what;
  planner.plan.raised.push_back(what);
  return true;
}

// Finds what all muscles would need if all had the same: the first trial that keeps them all, with
// no fewer iterations than any has got, or else the finest trial.
void find_uniform(Planner& planner) {
  FidelityPlan& plan = planner.plan;
  int iterations = 1;
  for (const MuscleFidelity& muscle : plan.fidelity.muscles) {
    if (has_forces(muscle.level)) iterations = std::max(iterations, muscle.iterations);
  }
  const int substeps = plan.fidelity.substeps;
  const auto begin = std::lower_bound(std::begin(kIterations), std::end(kIterations), iterations);
  for (auto next = begin; next != std::end(kIterations) && !plan.uniform_keeps; ++next) {
    const auto is_it = [&](const Trial& trial) {
      return trial.substeps == substeps && trial.iterations == *next &&
             trial.level == Level::kDynamic;
    };
    auto trial = std::find_if(planner.trials.begin(), planner.trials.end(), is_it);
    if (trial == planner.trials.end()) {
      run_trial(planner, {substeps, *next, Level::kDynamic, {}, {}});
      trial = std::prev(planner.trials.end());
    }
    plan.uniform_keeps = true;
    for (int m = 0; m < planner.muscles(); ++m) {
      plan.uniform_keeps &= trial->error[m] <= kMargin * planner.remaining(m);
    }
    plan.uniform_substeps = substeps;
    plan.uniform_iterations = *next;
    plan.uniform_work = sum(trial->work);
    for (int m = 0; m < planner.muscles(); ++m) plan.muscles[m].uniform_work = trial->work[m];
  }
}

// Runs the choice through the whole clip and sets its errors in probes and checks. True if all
// muscles keep the tolerance; otherwise those that do not have been given their next level.
bool run_whole_clip(Planner& planner) {
  const int last = planner.last;
  planner.model.fidelity = planner.plan.fidelity;
  std::vector<ChosenMuscle>& chosen = planner.plan.muscles;
  std::vector<int> slept(planner.muscles(), 0);
  double volume_error = 0.0;
  for (ChosenMuscle& muscle : chosen) muscle.probed_error = muscle.checked_error = 0.0;
  const State end = run_clip(planner, [&](int frame, const State& state) {
    for (int m = 0; m < state.count(); ++m) {
      slept[m] += frame > 0 && state.muscles[m].level == Level::kAsleep;
      volume_error = std::max(volume_error, state.muscles[m].volume_error);
    }
    for (const Window& window : planner.windows) {
      if (window.frame != frame) continue;
      for (int m = 0; m < state.count(); ++m) {
        const double error = largest_distance(state.muscles[m].x, window.x[m]);
        double& most = planner.is_check(window) ? chosen[m].checked_error : chosen[m].probed_error;
        most = std::max(most, error);
      }
    }
  });
  const std::vector<double> work = work_of(end);
  planner.plan.probe_work += sum(work);
  planner.plan.work = sum(work) / last;
  for (int m = 0; m < planner.muscles(); ++m) {
    const MuscleFidelity& fidelity = planner.plan.fidelity.muscles[m];
    chosen[m].level = slept[m] == last ? Level::kAsleep : fidelity.level;
    chosen[m].iterations = has_forces(fidelity.level) ? fidelity.iterations : 0;
    chosen[m].work = work[m] / last;
  }
  if (volume_error > planner.model.solver.tolerance->volume) {
    char found[60];
    std::snprintf(found, sizeof found, "the volume is off by %.3g of 1", volume_error);
    refuse_tolerance(planner, found);
  }
  bool all = true;
  for (int m = 0; m < planner.muscles(); ++m) {
    const double error = std::max(chosen[m].probed_error, chosen[m].checked_error);
    if (error <= (last <= kShortClip ? kWholeMargin : kCheckMargin) * planner.remaining(m))
      continue;
    if (raise(planner, m, error, chosen[m].checked_error > chosen[m].probed_error)) {
      all = false;
    } else if (error > planner.remaining(m)) {
      refuse_tolerance(planner, "muscle \"" + planner.model.muscles[m].name + "\" is " +
                                    millimetres(error) +
                                    " off the refined step at the finest level");
    }
  }
  return all;
}

}  // namespace

const char* level_name(Level level) {
  switch (level) {
    case Level::kAsleep:
      return "asleep";
    case Level::kGeometric:
      return "geometric";
    case Level::kQuasiStatic:
      return "quasi_static";
    case Level::kDynamic:
      break;
  }
  return "dynamic";
}

FidelityPlan plan_fidelity(const Model& model, int threads,
                           const std::function<void()>& check_stop) {
  Parallel parallel(threads);
  Planner planner{model, parallel, check_stop};
  planner.tolerance = model.solver.tolerance->position;
  planner.last = model.last_frame - model.first_frame;
  planner.model.has_skin = false;
  planner.model.skinned.reset();
  if (planner.last < 1) refuse_tolerance(planner, "one frame has no motion to probe");
  ProbeFrames frames = choose_probes(model);
  if (planner.last <= kShortClip) {
    frames.checks.clear();
    for (int frame = 1; frame <= planner.last; ++frame) frames.checks.push_back(frame);
  }
  planner.checks.insert(frames.checks.begin(), frames.checks.end());
  for (const int frame : frames.probes) planner.checks.erase(frame);
  std::set<int> all = planner.checks;
  all.insert(frames.probes.begin(), frames.probes.end());
  for (const int frame : all) planner.windows.push_back({frame, {}, {}, {}});
  for (const int frame : frames.probes) planner.plan.probed.push_back(model.first_frame + frame);
  for (const int frame : planner.checks) planner.plan.checked.push_back(model.first_frame + frame);
  planner.plan.muscles.resize(planner.muscles());
  find_references(planner);
  refuse_unknown(planner);
  choose(planner);
  for (int run = 1; !run_whole_clip(planner); ++run) {
    if (run == kMaxRuns)
      refuse_tolerance(planner, "no choice kept it in " + std::to_string(run) + " runs");
  }
  find_uniform(planner);
  return std::move(planner.plan);
}

}  // namespace thew::sim
