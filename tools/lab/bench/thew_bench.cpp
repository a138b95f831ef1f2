// SPDX-License-Identifier: Apache-2.0
//
// thew_bench SCENE: how fast the muscles are, and how right at that speed, as one JSON object.
// thew_bench SCENE --tolerance MM [--set KEY=VALUE]...: what solver.tolerance chooses there, and
// its time beside that of the cheapest step that is the same for all muscles and as right.
// thew_bench SCENE --copies OUT.svg: contact of 1 to 64 of it in one scene.
// thew_bench SCENE --skin: its skin layer as it comes, and with its volume kept.
// Times are CPU milliseconds of one thread, medians of interleaved runs; the figures that carry
// over between machines are the ratios.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <nlohmann/json.hpp>

#include "muscles/volume.h"
#include "sim/cache/durable_file.h"
#include "sim/fidelity/planner.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tools/base/exit_code.h"
#include "tools/lab/bench/copies.h"
#include "tools/lab/bench/scale_plot.h"

namespace thew::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kRuns = 5;

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

struct Run {
  double milliseconds = 0.0;  ///< CPU, a frame
  StageSeconds seconds;
  State state;  ///< at the last frame
};

Run simulate(const Model& model) {
  const int last = model.last_frame;
  Run run;
  Parallel one(1);
  State state = initial_state(model);
  settle(model, one, state);
  const int first = model.first_frame;
  const double begin = cpu_seconds();
  for (int f = first + 1; f <= last; ++f) {
    step_frame(model, (f - first) / model.fps, one, state, run.seconds);
  }
  run.milliseconds = 1e3 * (cpu_seconds() - begin) / (last - first);
  run.state = std::move(state);
  return run;
}

Model model_with(const std::string& scene, std::vector<std::string> overrides) {
  overrides.push_back("skin.enabled=false");
  return build_model(read_scene(scene, overrides));
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// Over nodes, and frames where it goes on.
struct Distance {
  double largest = 0.0, sum = 0.0, count = 0.0;  ///< mm, mm^2
  int frame = 0;                                 ///< of the largest
  double rms() const { return std::sqrt(sum / std::max(count, 1.0)); }
};
void add_distance(const State& a, const State& b, int frame, Distance& out) {
  for (int m = 0; m < a.count(); ++m) {
    for (size_t i = 0; i < a.muscles[m].x.size(); ++i) {
      const double d = 1e3 * (to_vec(a.muscles[m].x[i]) - to_vec(b.muscles[m].x[i])).norm();
      if (d > out.largest) out.largest = d, out.frame = frame;
      out.sum += d * d;
      ++out.count;
    }
  }
}

// Over all frames.
Distance distance(const Model& a, const Model& b) {
  Distance out;
  Parallel all(0);
  StageSeconds unused;
  State x = initial_state(a), y = initial_state(b);
  settle(a, all, x);
  settle(b, all, y);
  const int first = a.first_frame;
  for (int f = first + 1; f <= a.last_frame; ++f) {
    step_frame(a, (f - first) / a.fps, all, x, unused);
    step_frame(b, (f - first) / b.fps, all, y, unused);
    add_distance(x, y, f, out);
  }
  return out;
}

// Sag of the first muscle held horizontally: gravity across it against no gravity, no contact.
double sag(const std::string& scene) {
  const std::vector<std::string> still = {"contact.enabled=false"};
  std::vector<std::string> with = still, without = still;
  with.push_back("scene.gravity=[9.81, 0, 0]");
  without.push_back("scene.gravity=[0, 0, 0]");
  Model a = model_with(scene, with), b = model_with(scene, without);
  a.muscles.resize(1);
  b.muscles.resize(1);
  a.ignore.resize(1);
  b.ignore.resize(1);
  a.last_frame = b.last_frame = a.first_frame + 1;
  return distance(a, b).largest;
}

// Positions by frame, and CPU ms a frame. Every run settles by itself.
struct Motion {
  std::vector<std::vector<Points>> x;
  double milliseconds = 0.0, volume_error = 0.0;
};
Motion record(const Model& model) {
  const int first = model.first_frame, last = model.last_frame;
  Motion motion;
  Parallel one(1);
  StageSeconds unused;
  State state = initial_state(model);
  settle(model, one, state);
  for (int f = first; f <= last; ++f) {
    const double begin = cpu_seconds();
    if (f > first) step_frame(model, (f - first) / model.fps, one, state, unused);
    motion.milliseconds += 1e3 * (cpu_seconds() - begin) / std::max(last - first, 1);
    std::vector<Points>& rows = motion.x.emplace_back();
    for (const MuscleState& muscle : state.muscles) {
      rows.push_back(muscle.x);
      motion.volume_error = std::max(motion.volume_error, muscle.volume_error);
    }
  }
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

Model uniform(Scene scene, int substeps, int iterations) {
  scene.solver.integrator = "local_global";
  scene.solver.volume = "exact";
  scene.solver.substeps = substeps;
  scene.solver.iterations = iterations;
  return build_model(scene);
}

// Those of the grid whose error, in mm, is no larger.
std::vector<Setting> settings_within(const Scene& scene, const Motion& reference, double error) {
  std::vector<Setting> settings;
  for (const int substeps : {1, 2, 4}) {
    for (const int iterations : {1, 2, 3, 5}) {
      Setting setting{substeps, iterations, uniform(scene, substeps, iterations)};
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

int compare(const std::string& file, double millimetres, std::vector<std::string> overrides) {
  overrides.push_back("skin.enabled=false");
  Scene scene = read_scene(file, overrides);
  scene.solver.tolerance.reset();
  const Motion reference = record(uniform(scene, 8, 40));
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
  for (int i = 0; i < kRuns; ++i) {
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
  std::printf("%s\n", out.dump(2).c_str());
  return largest(errors) <= millimetres ? 0 : 1;
}

int run(const std::string& scene) {
  Json out;
  const Model model = model_with(scene, {});
  const int first = model.first_frame, last = model.last_frame;
  const Model none = model_with(scene, {"solver.volume=none"});
  const Model free = model_with(scene, {"contact.enabled=false"});
  const Model rough = model_with(scene, {"contact.friction=0.3"});
  std::string names;
  for (const Muscle& muscle : model.muscles) names += "\"" + muscle.name + "\",";
  const Model folding = model_with(scene, {"contact.self=[" + names + "]"});
  std::vector<double> whole, without_volume, without_contact, with_friction, with_self;
  std::vector<double> rig, contact, muscles;
  for (int i = 0; i < kRuns; ++i) {
    const Run a = simulate(model);
    whole.push_back(a.milliseconds);
    without_volume.push_back(simulate(none).milliseconds);
    without_contact.push_back(simulate(free).milliseconds);
    with_friction.push_back(simulate(rough).milliseconds);
    with_self.push_back(simulate(folding).milliseconds);
    const double per_frame = 1e3 / (last - first);
    rig.push_back(per_frame * a.seconds.rig);
    contact.push_back(per_frame * a.seconds.contact);
    muscles.push_back(per_frame * a.seconds.muscles);
  }
  out["scene"] = model.name;
  out["muscles"] = model.muscles.size();
  out["frames"] = last - first + 1;
  out["cpu_ms_per_frame"] = median(whole);
  out["frames_per_cpu_second"] = 1e3 / median(whole);
  out["wall_ms_per_frame"] = {
      {"rig", median(rig)}, {"contact", median(contact)}, {"muscles", median(muscles)}};
  out["ratio_to_no_volume"] = median(whole) / median(without_volume);
  out["ratio_to_no_contact"] = median(whole) / median(without_contact);
  out["ratio_of_friction"] = median(with_friction) / median(whole);
  out["ratio_of_self_contact"] = median(with_self) / median(whole);
  out["sag_mm"] = sag(scene);
  // Against the same model, step and iterations refined: all nodes, all frames.
  const Distance error =
      distance(model, model_with(scene, {"solver.substeps=8", "solver.iterations=40"}));
  out["error_mm"] = {{"max", error.largest}, {"in_frame", error.frame}, {"rms", error.rms()}};
  std::printf("%s\n", out.dump(2).c_str());
  return 0;
}

// CPU seconds of one search without memory, as near a bone as a node that touches it.
double price_of_query(const Model& model, const State& state) {
  const Surface& bone = model.surfaces[model.muscles.size()].surface;
  const BoneState& now = state.bones.front();
  const Points& from = now.x;
  constexpr int kRounds = 20;
  double sum = 0.0;
  const double begin = cpu_seconds();
  for (int r = 0; r < kRounds; ++r) {
    for (const Point& p : from) {
      const Vec3 near = to_vec(p) + 2e-3 * Vec3(1.0, 0.1 * r, -0.5);
      sum += closest_point(bone, now.bvh, now.x, near, 0.01).distance;
    }
  }
  const double each = (cpu_seconds() - begin) / (kRounds * static_cast<double>(from.size()));
  return std::isfinite(sum) ? each : 0.0;
}

int scale(const std::string& scene, const std::string& picture) {
  const ModelDef one = define_model(read_scene(scene));
  const double frames = one.last_frame - one.first_frame;
  Json out = {{"scene", one.name}};
  std::vector<ScalePoint> points;
  double nodes_of_one = 0.0, first = 0.0;
  for (const MuscleDef& muscle : one.muscles) nodes_of_one += muscle.mesh.vertices.size();
  for (const int count : {1, 2, 4, 8, 16, 32, 64}) {
    const Model model = build_model(copies_of(one, count, 1.0));
    const Run run = simulate(model);
    std::int64_t searches = 0;
    for (const MuscleState& muscle : run.state.muscles) {
      searches += muscle.memory.searches + muscle.face_memory.searches;
    }
    const int last = static_cast<int>(model.muscles.size() - one.muscles.size());
    const Point apart = run.state.muscles[last].x[0] - run.state.muscles[0].x[0];
    const double milliseconds = 1e3 * run.seconds.contact / frames, nodes = count * nodes_of_one;
    const double price = price_of_query(model, run.state);
    if (count == 1) first = milliseconds;
    const double grown = count * std::log(nodes) / std::log(nodes_of_one);
    out["copies"].push_back(
        {{"copies", count},
         {"nodes", nodes},
         {"contact_ms_per_frame", milliseconds},
         {"over_n_log_n", milliseconds / (first * grown)},
         {"searches_per_node_and_frame", searches / (nodes * frames)},
         {"query_us", 1e6 * price},
         {"queries_worth_per_node_and_frame", 1e-3 * milliseconds / (price * nodes)},
         {"off_the_first_um", 1e6 * std::abs(apart[2] - (count - 1.0))}});
    points.push_back({count, milliseconds, first * grown});
  }
  replace_durably(picture, draw_scale("Contact of " + one.name + ", 1 to 64 of it", points));
  std::printf("%s\n", out.dump(2).c_str());
  return 0;
}

// The skin alone, over the last state of the muscles: what a frame costs more than one without.
int skin(const std::string& scene) {
  const auto frame = [&](const char* setting) {
    const Run run = simulate(build_model(read_scene(scene, {setting})));
    return std::pair(run.milliseconds, run.state.skin.x);
  };
  const Model model = build_model(read_scene(scene, {}));
  if (!model.has_skin) throw Error(ErrorCode::kInput, scene + ": has no skin layer");
  std::vector<double> none, free, kept;
  double error = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    none.push_back(frame("skin.enabled=false").first);
    free.push_back(frame("skin.volume=none").first);
    const auto [milliseconds, x] = frame("skin.volume=exact");
    kept.push_back(milliseconds);
    const double volume = enclosed_volume(x, model.skin.surface.triangles);
    error = std::abs(volume - model.skin.volume) / model.skin.volume;
  }
  const double layer = median(free) - median(none), full = median(kept) - median(none);
  const Json out = {{"scene", model.name},
                    {"nodes", model.skin.rest.size()},
                    {"cpu_ms_per_frame", layer},
                    {"cpu_ms_per_frame_with_its_volume", full},
                    {"ratio_of_volume", full / layer},
                    {"volume_error", error}};
  std::printf("%s\n", out.dump(2).c_str());
  return 0;
}

int run_command(int argc, char** argv) {
  if (argc == 3 && std::string_view(argv[2]) == "--skin") return skin(argv[1]);
  if (argc == 4 && std::string_view(argv[2]) == "--copies") return scale(argv[1], argv[3]);
  std::vector<std::string> overrides;
  double tolerance = 0.0;
  bool understood = argc % 2 == 0;
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--set") overrides.push_back(argv[i + 1]);
    if (word == "--tolerance") tolerance = std::atof(argv[i + 1]);
    understood = understood && (word == "--set" || word == "--tolerance");
  }
  if (!understood || (tolerance <= 0.0) != (argc == 2)) {
    std::fprintf(
        stderr,
        "usage: thew_bench SCENE.toml [--tolerance MM [--set KEY=VALUE]... | --copies OUT.svg | "
        "--skin]\n");
    return 2;
  }
  return tolerance > 0.0 ? compare(argv[1], tolerance, overrides) : run(argv[1]);
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  try {
    return thew::tools::run_command(argc, argv);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "thew_bench: %s\n", error.what());
    return static_cast<int>(thew::tools::exit_code_of(error.code()));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "thew_bench: %s\n", error.what());
    return static_cast<int>(thew::tools::ExitCode::kSolver);
  }
}
