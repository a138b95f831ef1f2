// SPDX-License-Identifier: Apache-2.0
#include "tools/chart_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>

#include "sim/measure.h"
#include "sim/muscle_step.h"
#include "sim/step.h"
#include "tools/commands.h"
#include "tools/paper_run.h"

namespace thew {
namespace {

constexpr double kMostCost = 3.0;  // of the reference's: what costs more is no choice, and not run
constexpr int kTimedFrames = 24;   // at most, the first ones: a run of all is not repeated

using Frames = std::vector<std::vector<Rows>>;  // [frame][muscle]

Scene muscles_of_scene(const ChartAsk& ask) {
  Scene scene = read_scene(ask.scene);
  scene.skin.mesh.clear();
  scene.skin.skinned = false;
  if (ask.last > 0) scene.last_frame = ask.last;
  if (scene.last_frame <= scene.first_frame) {
    throw Error(ExitCode::kUsage,
                scene.file.string() + ": a chart needs two frames or more; give scene.frames");
  }
  return scene;
}

Model model_with(Scene scene, const ChartSetting& setting) {
  scene.solver.integrator = setting.integrator;
  scene.solver.volume = setting.volume;
  scene.solver.substeps = setting.substeps;
  scene.solver.iterations = setting.iterations;
  return build_model(scene);
}

// Calls on_frame(model, state) at each frame, the first one included; settles once for all runs of
// a point. What the solver cannot do is the point's failure; all other errors end the chart.
void simulate(const Scene& scene, ChartPoint& point, int last,
              const std::function<void(const Model&, State&)>& on_frame,
              std::optional<State>& settled, double& seconds) {
  const Model model = model_with(scene, point.setting);
  Parallel one(1);
  StageSeconds stages;
  try {
    if (!settled) {
      State rest = initial_state(model);
      settle(model, one, rest, [] { stop_if_interrupted(); });
      settled = rest;
    }
    State state = *settled;
    if (on_frame) on_frame(model, state);
    for (int frame = scene.first_frame + 1; frame <= last; ++frame) {
      stop_if_interrupted();
      const double begin = cpu_seconds();
      step_frame(model, (frame - scene.first_frame) / scene.fps, one, state, stages);
      seconds += cpu_seconds() - begin;
      if (on_frame) on_frame(model, state);
    }
  } catch (const Error& error) {
    if (error.code() != ExitCode::kSolver) throw;
    point.failure = error.what();
  }
}

// CPU seconds of the very first frame; 0 where it fails, which the whole run will tell.
double first_frame(const Scene& scene, const ChartSetting& setting) {
  stop_if_interrupted();
  const Model model = model_with(scene, setting);
  Parallel one(1);
  StageSeconds stages;
  State state = initial_state(model);
  const double begin = cpu_seconds();
  try {
    step_frame(model, state.time + 1.0 / scene.fps, one, state, stages);
  } catch (const Error& error) {
    if (error.code() != ExitCode::kSolver) throw;
    return 0.0;
  }
  return cpu_seconds() - begin;
}

void give_up_slow(const Scene& scene, const ChartSetting& reference,
                  std::vector<ChartPoint>& points) {
  const double most = kMostCost * first_frame(scene, reference);
  for (ChartPoint& point : points) {
    const double seconds = first_frame(scene, point.setting);
    if (seconds <= most) continue;
    point.failure = "given up: its first frame took " + std::to_string(std::lround(1e3 * seconds)) +
                    " ms of CPU, over three times the reference's";
  }
}

Frames run_reference(const Scene& scene, ChartPoint& point) {
  Frames frames;
  double unused = 0.0;
  std::optional<State> settled;
  const auto keep = [&](const Model&, State& state) {
    std::vector<Rows>& rows = frames.emplace_back();
    for (const MuscleState& muscle : state.muscles) rows.push_back(muscle.x);
  };
  simulate(scene, point, scene.last_frame, keep, settled, unused);
  if (!point.failure.empty()) {
    throw Error(ExitCode::kSolver, scene.file.string() + ": the reference, " +
                                       setting_name(point.setting) + ", failed: " + point.failure +
                                       "; make the scene bake with it first");
  }
  return frames;
}

double rest_diagonal(const Muscle& muscle) {
  Vec3 low = muscle.rest.vertices.front(), high = low;
  for (const Vec3& x : muscle.rest.vertices) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return (high - low).norm();
}

void measure_point(const Scene& scene, const Frames& reference, ChartPoint& point,
                   std::optional<State>& settled) {
  double sum = 0.0, unused = 0.0;
  std::size_t count = 0, frame = 0;
  std::vector<double> areas;
  Parallel one(1);
  const auto compare = [&](const Model& model, State& state) {
    if (areas.empty()) areas = rest_belly_areas(model, initial_state(model));
    for (int m = 0; m < state.count(); ++m) {
      const double diagonal_mm = 1e3 * rest_diagonal(model.muscles[m]);
      const Rows& there = reference[frame][m];
      for (std::size_t i = 0; i < there.size(); ++i, ++count) {
        const double mm = 1e3 * (to_vec(state.muscles[m].x[i]) - to_vec(there[i])).norm();
        point.largest_mm = std::max(point.largest_mm, mm);
        point.percent = std::max(point.percent, 100.0 * mm / diagonal_mm);
        sum += mm * mm;
      }
    }
    const FrameMeasures measures = measure(model, areas, one, state);
    for (const MuscleMeasures& muscle : measures.muscles) {
      point.volume_error = std::max(point.volume_error, muscle.volume_error);
    }
    point.penetration_mm = std::max(point.penetration_mm, 1e3 * measures.contact_penetration);
    ++frame;
  };
  simulate(scene, point, scene.last_frame, compare, settled, unused);
  if (!point.failure.empty()) {
    ChartPoint failed;
    failed.setting = point.setting;
    failed.is_default = point.is_default;
    failed.failure = point.failure;
    point = failed;
    return;
  }
  point.rms_mm = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

std::vector<ChartPoint> points_of(const std::vector<ChartSetting>& settings, const Scene& scene) {
  const auto& own = scene.solver;
  std::vector<ChartPoint> points;
  for (ChartSetting setting : settings) {
    ChartPoint& point = points.emplace_back();
    point.setting = setting;
    if (setting.integrator == "explicit") setting.iterations = own.iterations;
    point.is_default =
        setting == ChartSetting{own.integrator, own.volume, own.substeps, own.iterations};
  }
  return points;
}

}  // namespace

std::string setting_name(const ChartSetting& setting) {
  const bool is_explicit = setting.integrator == "explicit";
  return setting.integrator + " " + std::to_string(setting.substeps) +
         (is_explicit ? "" : "x" + std::to_string(setting.iterations)) + " " + setting.volume;
}

std::vector<ChartSetting> chart_settings(const Scene& scene, int explicit_limit) {
  const auto& own = scene.solver;
  std::vector<ChartSetting> settings;
  const auto add = [&](const ChartSetting& setting) {
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) {
      settings.push_back(setting);
    }
  };
  add({own.integrator, own.volume, own.substeps,
       own.integrator == "explicit" ? 1 : own.iterations});
  for (const int substeps : {1, 2, 4}) {
    for (const int iterations : {1, 2, 3, 5, 10}) {
      add({"local_global", "exact", substeps, iterations});
    }
  }
  // A lower count is raised by the solver for each muscle to what its own spectrum asks for.
  for (const int substeps : {1, 2 * explicit_limit}) {
    for (const char* volume : {"linear", "exact", "exact_always"}) {
      add({"explicit", volume, substeps, 1});
    }
  }
  for (const char* volume : {"none", "printed", "linear"}) {
    add({"local_global", volume, 1, 3});
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

Chart run_chart(const ChartAsk& ask) {
  const Scene scene = muscles_of_scene(ask);
  Chart chart;
  chart.scene = scene.name;
  chart.frames = scene.last_frame - scene.first_frame + 1;
  chart.repetitions = ask.repetitions;
  chart.timed_frames = std::min(kTimedFrames, chart.frames - 1);
  const Model model = build_model(scene);
  chart.muscles = static_cast<int>(model.muscles.size());
  int limit = 1;
  for (const Muscle& muscle : model.muscles) {
    chart.nodes += static_cast<int>(muscle.rest.vertices.size());
    limit = std::max(limit, explicit_substeps(muscle, 1.0 / scene.fps));
  }
  chart.points = points_of(chart_settings(scene, limit), scene);
  // The exact volume, whatever the scene's: what a method without it lacks is its error.
  for (const auto& [substeps, iterations] :
       {std::pair(2, 20), std::pair(4, 20), std::pair(8, 40)}) {
    chart.references.emplace_back().setting = {"local_global", "exact", substeps, iterations};
  }

  std::vector<ChartPoint*> measured;
  give_up_slow(scene, chart.references.back().setting, chart.points);
  for (ChartPoint& point : chart.points) measured.push_back(&point);
  for (ChartPoint& point : chart.references) measured.push_back(&point);
  const int count = static_cast<int>(measured.size()),
            points = static_cast<int>(chart.points.size());
  const int total = 1 + count + ask.repetitions * points;
  const Frames reference = run_reference(scene, chart.references.back());
  int done = 1;
  ask.on_step(done, total);
  std::vector<std::optional<State>> settled(count);
  std::mutex one_at_a_time;
  Parallel parallel(ask.threads);
  parallel.each(count, [&](int k) {
    if (measured[k]->failure.empty()) measure_point(scene, reference, *measured[k], settled[k]);
    const std::lock_guard lock(one_at_a_time);
    ask.on_step(++done, total);
  });

  std::vector<std::vector<double>> seconds(points);
  for (int r = 0; r < ask.repetitions; ++r) {
    for (int k = 0; k < points; ++k) {
      if (chart.points[k].failure.empty()) {
        simulate(scene, chart.points[k], scene.first_frame + chart.timed_frames, {}, settled[k],
                 seconds[k].emplace_back(0.0));
      }
      ask.on_step(++done, total);
    }
  }
  for (int k = 0; k < points; ++k) {
    if (seconds[k].empty()) continue;
    chart.points[k].milliseconds = 1e3 * median(seconds[k]) / chart.timed_frames;
  }
  for (const std::size_t i : pareto_front(chart.points, &ChartPoint::largest_mm)) {
    chart.points[i].on_front = true;
  }
  return chart;
}

}  // namespace thew
