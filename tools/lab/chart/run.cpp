// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/chart/run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "sim/bake/measure.h"
#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tools/base/signals.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"

namespace thew::tools {
namespace {
constexpr double kMostCost = 3.0;  // of the reference's: what costs more is no choice, and not run
// A scene and what its files hold, read once: each file is read by a child process, and a fork is
// dear to a program that holds all frames of a reference.
struct ReadScene : Scene {
  ModelDef def;
};

Scene with_setting(Scene scene, const ChartSetting& setting) {
  scene.solver.integrator = setting.integrator;
  scene.solver.volume = setting.volume;
  scene.solver.substeps = setting.substeps;
  scene.solver.iterations = setting.iterations;
  return scene;
}

Model solved(const ReadScene& scene, const ChartSetting& setting) {
  ModelDef def = scene.def;
  solve_as(with_setting(scene, setting), def);
  return build_model(def);
}

ReadScene muscles_of_scene(const ChartAsk& ask) {
  ReadScene scene = {read_scene(ask.scene), {}};
  scene.skin.mesh.clear();
  scene.skin.skinned = false;
  scene.solver.tolerance.reset();  // every setting is charted by itself
  if (ask.last > 0) scene.last_frame = ask.last;
  if (scene.last_frame <= scene.first_frame) {
    throw Error(ErrorCode::kUsage,
                scene.file.string() + ": a chart needs two frames or more; give scene.frames");
  }
  scene.def = define_model(scene);
  return scene;
}

// Calls on_frame(model, state) at each frame, the first one included; settles once for all runs of
// a point. What the solver cannot do, explicit steps without number among it, is the point's
// failure; all other errors end the chart. CPU seconds.
double simulate(const ReadScene& scene, ChartPoint& point, int last,
                const std::function<void(const Model&, State&)>& on_frame,
                std::optional<State>& settled) {
  Model model = solved(scene, point.setting);
  model.solver.rungs = false;  // a failure is what a chart shows
  try {
    if (!settled) settled = settled_state(model);
    return play(model, *settled, last,
                [&](int, State& state) {
                  if (on_frame) on_frame(model, state);
                })
        .seconds;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kSolver && error.code() != ErrorCode::kUsage) throw;
    point.failure = error.what();
    return 0.0;
  }
}

// CPU seconds of the very first frame; 0 where it fails, which the whole run will tell. Explicit
// steps are as many as the time is long, tens of thousands a frame on the arm: some of them tell.
// A frame that is solved by itself is the dearer the farther its pose is: the one in the middle.
double price_of_frame(const ReadScene& scene, const ChartSetting& setting) {
  stop_if_interrupted();
  Model model = solved(scene, setting);
  model.solver.rungs = false;
  Parallel one(1);
  StageSeconds stages;
  State state = initial_state(model);
  double share = 1.0;
  if (setting.integrator == "explicit") {
    share = 1.0 / std::max(model.solver.substeps, 100);
    model.solver.substeps = 1;
  }
  const double begin = cpu_seconds();
  try {
    if (stands_alone(model)) {
      const double middle = 0.5 * (scene.last_frame - scene.first_frame) / scene.fps;
      solve_lone_frame(model, middle, one, state, stages, [] { stop_if_interrupted(); });
    } else {
      step_frame(model, state.time + share / scene.fps, one, state, stages);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kSolver && error.code() != ErrorCode::kUsage) throw;
    return 0.0;
  }
  return (cpu_seconds() - begin) / share;
}

void give_up_slow(const ReadScene& scene, const ChartSetting& reference, double longest_run,
                  Chart& chart) {
  const double most = kMostCost * price_of_frame(scene, reference);
  const auto refusal = [&](const ChartSetting& setting) {
    const double seconds = price_of_frame(scene, setting);
    if (seconds <= most) return std::string();
    return std::string(kGivenUp) + "a frame of it takes about " +
           std::to_string(std::lround(1e3 * seconds)) +
           " ms of CPU, over three times the reference's";
  };
  for (ChartPoint& point : chart.points) {
    if (point.failure.empty()) point.failure = refusal(point.setting);
  }
  const int frames = chart.frames + static_cast<int>(std::lround(scene.settle * scene.fps));
  for (Refinement& refinement : chart.refinements) {
    if (refinement.settings.back() == reference || !refinement.failure.empty()) continue;
    const double seconds = frames * price_of_frame(scene, refinement.settings.back());
    if (seconds <= longest_run) continue;
    refinement.failure = std::string(kGivenUp) + "its finest run would take about " +
                         std::to_string(std::lround(seconds)) + " s of CPU";
  }
}

Frames run_frames(const ReadScene& scene, ChartPoint& point) {
  Frames frames;
  std::optional<State> settled;
  const auto keep = [&](const Model&, State& state) {
    std::vector<Points>& rows = frames.emplace_back();
    for (const MuscleState& muscle : state.muscles) rows.push_back(muscle.x);
  };
  simulate(scene, point, scene.last_frame, keep, settled);
  return frames;
}

// Fills in the figures and leaves the frames of the finest run; none where a run failed.
Frames refine(const ReadScene& scene, Parallel& parallel, const std::function<void()>& on_run,
              Refinement& refinement) {
  const int count = static_cast<int>(refinement.settings.size());
  std::vector<Frames> runs(count);
  std::vector<std::string> failures(count);
  parallel.each(count, [&](int i) {
    const int k = count - 1 - i;  // the longest one first
    ChartPoint point;
    point.setting = refinement.settings[k];
    runs[k] = run_frames(scene, point);
    failures[k] = point.failure;
    on_run();
  });
  for (int k = 0; k < count; ++k) {
    if (failures[k].empty()) continue;
    refinement.failure = setting_name(refinement.settings[k]) + ": " + failures[k];
    return {};
  }
  for (int k = 0; k + 1 < count; ++k) {
    const NodeDistance next = distance_of(runs[k], runs[k + 1]);
    refinement.largest_mm.push_back(next.largest);
    refinement.rms_mm.push_back(next.rms());
    if (k == 0) continue;
    const double before = refinement.rms_mm[k - 1];
    refinement.order.push_back(next.rms() > 0.0 && before > 0.0 ? std::log2(before / next.rms())
                                                                : 0.0);
  }
  return std::move(runs.back());
}

// `own`: of the finest run of the point's integrator, empty where there is none.
void measure_point(const ReadScene& scene, const Frames& reference, const Frames& own,
                   ChartPoint& point, std::optional<State>& settled) {
  NodeDistance distance, from_own;
  std::size_t frame = 0;
  std::optional<Measuring> measuring;
  Parallel one(1);
  const auto compare = [&](const Model& model, State& state) {
    if (!measuring) measuring = start_measuring(model, initial_state(model));
    for (int m = 0; m < state.count(); ++m) {
      const double diagonal_mm = 2e3 * bounds_of(model.muscles[m].rest.vertices).radius();
      const double mm = add_distance(state.muscles[m].x, reference[frame][m], distance);
      point.percent = std::max(point.percent, 100.0 * mm / diagonal_mm);
      if (!own.empty()) add_distance(state.muscles[m].x, own[frame][m], from_own);
    }
    const FrameMeasures measures = measure(model, *measuring, one, state);
    for (const MuscleMeasures& muscle : measures.muscles) {
      point.volume_error = std::max(point.volume_error, muscle.volume_error);
    }
    point.penetration_mm = std::max(point.penetration_mm, 1e3 * measures.contact_penetration);
    ++frame;
  };
  simulate(scene, point, scene.last_frame, compare, settled);
  if (!point.failure.empty()) {
    ChartPoint failed;
    failed.setting = point.setting;
    failed.is_default = point.is_default;
    failed.failure = point.failure;
    point = failed;
    return;
  }
  point.largest_mm = distance.largest;
  point.rms_mm = distance.rms();
  if (!own.empty()) point.own_mm = from_own.largest;
}

std::vector<ChartPoint> points_of(const std::vector<ChartSetting>& settings, const Scene& scene) {
  const auto& own = scene.solver;
  std::vector<ChartPoint> points;
  for (ChartSetting setting : settings) {
    ChartPoint& point = points.emplace_back();
    point.setting = setting;
    if (setting.integrator == "explicit") setting.iterations = own.iterations;
    if (setting.integrator == "quasi_static") {
      setting.iterations = own.iterations;
      setting.substeps = own.substeps;
    }
    point.is_default =
        setting == ChartSetting{own.integrator, own.volume, own.substeps, own.iterations};
  }
  return points;
}

std::string held_volume(const std::string& volume) { return volume == "zonal" ? volume : "exact"; }

}  // namespace

NodeDistance distance_of(const Frames& a, const Frames& b) {
  NodeDistance out;
  for (std::size_t f = 0; f < a.size(); ++f) {
    for (std::size_t m = 0; m < a[f].size(); ++m) add_distance(a[f][m], b[f][m], out);
  }
  return out;
}

Model solved_as(Scene scene, const ChartSetting& setting) {
  return build_model(with_setting(std::move(scene), setting));
}

std::string setting_name(const ChartSetting& setting) {
  std::string counts = " " + std::to_string(setting.substeps);
  if (setting.integrator == "quasi_static") {
    counts.clear();
  } else if (setting.integrator != "explicit") {
    counts += "x" + std::to_string(setting.iterations);
  }
  return setting.integrator + counts + " " + setting.volume;
}

std::string point_name(const ChartPoint& point) {
  return point.peer.empty() ? setting_name(point.setting) : point.peer + ", " + point.label;
}

// The exact volume, whatever the scene's: what a method without it lacks is its error. Zones are
// one more thing to hold.
std::vector<Refinement> chart_refinements(int explicit_limit, const std::string& volume) {
  std::vector<Refinement> refinements(3);
  refinements[0].integrator = "local_global";
  refinements[1].integrator = "xpbd";
  refinements[2].integrator = "explicit";
  for (const int part : {1, 2, 4, 8}) {
    refinements[0].settings.push_back({"local_global", held_volume(volume), part, 40});
    refinements[1].settings.push_back({"xpbd", "exact", 8 * part, 40});
    if (part == 8) continue;
    refinements[2].settings.push_back({"explicit", "exact", explicit_limit * part, 1});
  }
  return refinements;
}

std::vector<ChartSetting> chart_settings(const Scene& scene) {
  const auto& own = scene.solver;
  std::vector<ChartSetting> settings;
  const auto add = [&](const ChartSetting& setting) {
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) {
      settings.push_back(setting);
    }
  };
  const bool iterates = own.integrator == "local_global" || own.integrator == "xpbd";
  add({own.integrator, own.volume, own.integrator == "quasi_static" ? 1 : own.substeps,
       iterates ? own.iterations : 1});
  const std::string held = held_volume(own.volume);
  for (const int substeps : {1, 2, 4}) {
    for (const int iterations : {1, 2, 3, 5, 10}) {
      add({"local_global", held, substeps, iterations});
    }
  }
  for (const int iterations : {1, 3, 10}) add({"local_global", "exact", 1, iterations});
  for (const int substeps : {4, 16}) {
    for (const int iterations : {1, 4, 16}) add({"xpbd", "exact", substeps, iterations});
  }
  add({"xpbd", "exact", 64, 1});
  for (const std::string& volume : {held, std::string("exact")}) {
    add({"quasi_static", volume, 1, 1});
  }
  for (const int substeps : {1, 4, 16}) add({"explicit", "exact", substeps, 1});
  for (const char* volume : {"linear", "exact_always"}) add({"explicit", volume, 1, 1});
  for (const char* volume : {"none", "penalty", "printed", "linear"}) {
    add({"local_global", volume, 1, 3});
    add({"xpbd", volume, 4, 4});
    if (std::string(volume) != "linear") add({"explicit", volume, 1, 1});
  }
  return settings;
}

std::vector<std::size_t> pareto_front(const std::vector<ChartPoint>& points,
                                      double ChartPoint::*error) {
  std::vector<std::size_t> order(points.size()), front;
  std::iota(order.begin(), order.end(), 0);
  std::erase_if(order, [&](std::size_t i) { return !points[i].failure.empty(); });
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double cost_a = points[a].milliseconds, cost_b = points[b].milliseconds;
    return cost_a < cost_b || (cost_a == cost_b && points[a].*error < points[b].*error);
  });
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (!(points[i].*error < best)) continue;
    best = points[i].*error;
    front.push_back(i);
  }
  return front;
}

namespace {

// What is to be run, but not what comes of it.
Chart lay_out(const ChartAsk& ask, const ReadScene& scene) {
  Chart chart;
  chart.scene = scene.name;
  chart.frames = scene.last_frame - scene.first_frame + 1;
  chart.repetitions = ask.repetitions;
  chart.timed_frames = std::min(kTimedFrames, chart.frames - 1);
  const Model model = build_model(scene.def);
  chart.muscles = static_cast<int>(model.muscles.size());
  int limit = 1;
  for (int m = 0; m < chart.muscles; ++m) {
    chart.nodes += static_cast<int>(model.muscles[m].rest.vertices.size());
    // More than a step may be divided into: a frame is divided here, and given up where it is slow.
    limit = std::max(limit, static_cast<int>(std::min(
                                stable_explicit_substeps(model, m, 1.0 / scene.fps), 1e6)));
  }
  chart.points = points_of(chart_settings(scene), scene);
  chart.refinements = chart_refinements(limit, scene.solver.volume);
  const char* unsolved = "cannot solve the scene's friction, or a muscle with itself";
  for (ChartPoint& point : chart.points) {
    if (!can_solve_contact(scene, point.setting.integrator)) point.failure = unsolved;
  }
  for (Refinement& refinement : chart.refinements) {
    if (!can_solve_contact(scene, refinement.integrator)) refinement.failure = unsolved;
  }
  chart.reference = chart.refinements.front().settings.back();
  give_up_slow(scene, chart.reference, ask.longest_run, chart);
  return chart;
}

using Finest = std::map<std::string, Frames>;  // by integrator

Finest refine_all(const ReadScene& scene, Parallel& parallel, const std::function<void()>& on_run,
                  Chart& chart) {
  Finest finest;
  for (Refinement& refinement : chart.refinements) {
    if (!refinement.failure.empty()) continue;
    Frames& frames = finest[refinement.integrator] = refine(scene, parallel, on_run, refinement);
    if (&refinement == &chart.refinements.front() && frames.empty()) {
      throw Error(ErrorCode::kSolver, scene.file.string() + ": the reference failed, " +
                                          refinement.failure +
                                          "; make the scene bake with it first");
    }
    if (!frames.empty()) {
      refinement.apart_mm = distance_of(frames, finest[chart.reference.integrator]).largest;
    }
  }
  return finest;
}

}  // namespace

void time_points(const std::function<double(std::size_t)>& seconds_of,
                 const std::function<void()>& on_run, Chart& chart) {
  std::vector<std::vector<double>> seconds(chart.points.size());
  for (int r = 0; r < chart.repetitions; ++r) {
    for (std::size_t k = 0; k < chart.points.size(); ++k) {
      if (chart.points[k].failure.empty()) seconds[k].push_back(seconds_of(k));
      on_run();
    }
  }
  for (std::size_t k = 0; k < chart.points.size(); ++k) {
    if (seconds[k].empty()) continue;
    chart.points[k].milliseconds = 1e3 * median(seconds[k]) / chart.timed_frames;
  }
}

Chart run_chart(const ChartAsk& ask) {
  const ReadScene scene = muscles_of_scene(ask);
  Chart chart = lay_out(ask, scene);
  const int points = static_cast<int>(chart.points.size());
  int done = 0, total = (1 + ask.repetitions) * points;
  for (const Refinement& refinement : chart.refinements) {
    if (refinement.failure.empty()) total += static_cast<int>(refinement.settings.size());
  }
  std::mutex one_at_a_time;
  const auto on_run = [&] {
    const std::lock_guard lock(one_at_a_time);
    ask.on_step(++done, total);
  };
  Parallel parallel(ask.threads);
  const Finest finest = refine_all(scene, parallel, on_run, chart);
  const Frames& reference = finest.at(chart.reference.integrator);
  const Frames none;
  std::vector<std::optional<State>> settled(points);
  parallel.each(points, [&](int k) {
    ChartPoint& point = chart.points[k];
    const auto own = finest.find(point.setting.integrator);
    if (point.failure.empty()) {
      measure_point(scene, reference, own == finest.end() ? none : own->second, point, settled[k]);
    }
    on_run();
  });
  const auto seconds_of = [&](std::size_t k) {
    const int last = scene.first_frame + chart.timed_frames;
    return simulate(scene, chart.points[k], last, {}, settled[k]);
  };
  time_points(seconds_of, on_run, chart);
  for (const std::size_t i : pareto_front(chart.points, &ChartPoint::largest_mm)) {
    chart.points[i].on_front = true;
  }
  return chart;
}

}  // namespace thew::tools
