// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "sim/fidelity/planner.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"
#include "tools/lab/bench/benches.h"
#include "tools/lab/chart/run.h"

namespace thew::tools {
namespace {

using Json = nlohmann::ordered_json;

// Positions by frame, and CPU ms a frame. Every run settles by itself.
struct Motion {
  std::vector<std::vector<Points>> x;
  double milliseconds = 0.0, volume_error = 0.0;
};
Motion record(const Model& model) {
  Motion motion;
  const Played played = play(model, settled_state(model), 0, [&](int, const State& state) {
    std::vector<Points>& rows = motion.x.emplace_back();
    for (const MuscleState& muscle : state.muscles) {
      rows.push_back(muscle.x);
      motion.volume_error = std::max(motion.volume_error, muscle.volume_error);
    }
  });
  motion.milliseconds = played.milliseconds_a_frame(model);
  return motion;
}

// mm, by muscle, the largest of all nodes and frames.
std::vector<double> errors_of(const Motion& motion, const Motion& reference) {
  std::vector<double> errors(reference.x[0].size(), 0.0);
  for (size_t f = 0; f < reference.x.size(); ++f) {
    for (size_t m = 0; m < errors.size(); ++m) {
      errors[m] = std::max(errors[m], 1e3 * largest_distance(motion.x[f][m], reference.x[f][m]));
    }
  }
  return errors;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// A step that is the same for all muscles.
struct Setting {
  int substeps, iterations;
  Model model;
  double error = 0.0;
  std::vector<double> milliseconds = {};
};

// Those of the grid whose error, in mm, is no larger.
std::vector<Setting> settings_within(const Scene& scene, const Motion& reference, double error) {
  std::vector<Setting> settings;
  for (const int substeps : {1, 2, 4}) {
    for (const int iterations : {1, 2, 3, 5}) {
      Setting setting{substeps, iterations,
                      solved_as(scene, {"local_global", "exact", substeps, iterations})};
      setting.error = largest(errors_of(record(setting.model), reference));
      if (setting.error <= error) settings.push_back(std::move(setting));
    }
  }
  return settings;
}

// Beside `ours`, CPU ms a frame; null where none of them is as right.
Json cheapest_within(const std::vector<Setting>& settings, double error, double ours) {
  const Setting* cheapest = nullptr;
  for (const Setting& setting : settings) {
    if (setting.error > error) continue;
    if (!cheapest || median(setting.milliseconds) < median(cheapest->milliseconds)) {
      cheapest = &setting;
    }
  }
  if (!cheapest) return {};
  const double ms = median(cheapest->milliseconds);
  return {{"substeps", cheapest->substeps},
          {"iterations", cheapest->iterations},
          {"error_mm", cheapest->error},
          {"cpu_ms_per_frame", ms},
          {"tolerance_over_it", ours / ms}};
}

Json muscles_of(const Model& model, const FidelityPlan& plan, const std::vector<double>& errors) {
  Json out;
  for (size_t m = 0; m < errors.size(); ++m) {
    const ChosenMuscle& muscle = plan.muscles[m];
    out.push_back({{"name", model.muscles[m].name},
                   {"level", level_name(muscle.level)},
                   {"iterations", muscle.iterations},
                   {"error_mm", errors[m]},
                   {"error_probed_mm", 1e3 * muscle.probed_error},
                   {"error_checked_mm", 1e3 * muscle.checked_error},
                   {"error_refined_mm", 1e3 * muscle.refined_error},
                   {"because", muscle.reason}});
  }
  return out;
}

}  // namespace

Json tolerance_of(const std::string& file, double millimetres, std::vector<std::string> overrides,
                  int repetitions) {
  overrides.push_back("skin.enabled=false");
  Scene scene = read_scene(file, overrides);
  scene.solver.tolerance.reset();
  const Motion reference = record(solved_as(scene, {"local_global", "exact", 8, 40}));
  Scene with = scene;
  with.solver.tolerance.emplace();
  with.solver.tolerance->position = 1e-3 * millimetres;
  with.solver.tolerance->location = "--tolerance";
  Model model = build_model(with);
  const double begin = cpu_seconds();
  const FidelityPlan plan = plan_fidelity(model, 1);
  const double probes = cpu_seconds() - begin;
  model.fidelity = plan.fidelity;
  const Motion chosen = record(model);
  const std::vector<double> errors = errors_of(chosen, reference);
  std::vector<Setting> settings =
      settings_within(scene, reference, std::max(millimetres, largest(errors)));
  std::vector<double> ours;
  for (int i = 0; i < repetitions; ++i) {
    ours.push_back(record(model).milliseconds);
    for (Setting& setting : settings) {
      setting.milliseconds.push_back(record(setting.model).milliseconds);
    }
  }
  Json out = {{"scene", scene.name},
              {"frames", reference.x.size()},
              {"tolerance_mm", millimetres},
              {"error_mm", largest(errors)},
              {"volume_error", chosen.volume_error},
              {"cpu_ms_per_frame", median(ours)},
              {"work_per_frame", plan.work},
              {"probes", {{"cpu_seconds", probes}, {"work", plan.probe_work}}}};
  const auto add_cheapest = [&](const char* name, double error) {
    const Json cheapest = cheapest_within(settings, error, median(ours));
    if (!cheapest.is_null()) out[name] = cheapest;
  };
  add_cheapest("uniform_within_the_tolerance", millimetres);
  add_cheapest("uniform_with_the_same_error", largest(errors));
  out["muscles"] = muscles_of(model, plan, errors);
  return out;
}

}  // namespace thew::tools
