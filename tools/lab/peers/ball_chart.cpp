// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/peers/ball_chart.h"

#include <functional>

#include "sim/cache/durable_file.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/lab/base/table.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/paper/ball.h"
#include "tools/lab/peers/peer_runs.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kTetrahedra = 3528;  // the paper's for this ball's 1,766 triangles
constexpr int kRepetitions = 3;    // of which times are the medians
constexpr double kPenalty = 1e5;   // Pa

struct Run {
  ChartPoint point;
  std::function<Outcome()> run;
};

std::vector<Run> our_runs(const fs::path& scenes) {
  const Scene ball = read_scene(scenes / "ball.toml", {"scene.frames=1-46"});
  std::vector<Run> runs;
  const auto add = [&](const ChartSetting& setting) {
    const Model model = solved_as(ball, setting);
    Run& run = runs.emplace_back();
    run.point.setting = setting;
    run.point.is_default = setting.integrator == "explicit" && setting.volume == "exact";
    run.run = [model] { return run_our_ball(model); };
  };
  for (const char* volume : {"exact", "exact_always", "linear", "penalty", "none"}) {
    add({"explicit", volume, 1, 1});
  }
  for (const int iterations : {1, 3, 10, 30}) add({"local_global", "exact", 1, iterations});
  for (const int iterations : {3, 10}) add({"local_global", "exact", 4, iterations});
  for (const char* volume : {"penalty", "none"}) add({"local_global", volume, 1, 3});
  for (const int substeps : {4, 16}) {
    for (const int iterations : {1, 16}) add({"xpbd", "exact", substeps, iterations});
  }
  return runs;
}

// The most accurate of its grid for each number of steps.
std::vector<Run> bullet_runs(const Model& model) {
  std::vector<Run> runs;
  for (const int steps : {1, 2, 5, 10, 20, 40}) {
    const BestPeer best = most_accurate(
        steps, [&](const BulletSetting& setting) { return run_bullet_ball(model, setting); });
    Run& run = runs.emplace_back();
    run.point.setting = {"Bullet", "penalty", steps, 1};
    run.point.peer = "Bullet soft body";
    run.point.label = std::to_string(steps) + (steps == 1 ? " step" : " steps");
    if (best.volume_error > 1.0) {
      run.point.failure = "no setting of the grid is stable";
      continue;
    }
    run.run = [&model, setting = best.setting] { return run_bullet_ball(model, setting); };
  }
  return runs;
}

Run fem_run(const Model& model) {
  Run run;
  run.point.setting = {"FEM", "penalty", 1, 8};
  run.point.peer = "linear finite elements";
  run.point.label = "FEM";
  run.run = [&model] {
    const FemRun fem = run_linear_ball(model, kTetrahedra, kPenalty, kHalfHeight);
    const size_t nodes = model.muscles[0].rest.vertices.size();
    Outcome out;
    out.milliseconds = 1e3 * fem.seconds;
    out.volume_error = fem.volume_error;
    out.stable = !fem.failed;
    for (size_t i = 0; out.stable && i < nodes; ++i) {
      out.held.push_back(to_point(fem.kept.at(kHalfHeight)[i]));
    }
    return out;
  };
  return run;
}

void measure(std::vector<Run>& runs) {
  FemBody rest, truth;
  if (!squeeze_true_ball(kFinestTruth, rest, truth).converged) {
    throw Error(ErrorCode::kSolver, "the neo-Hookean ball did not converge");
  }
  std::vector<std::vector<double>> times(runs.size());
  for (int r = 0; r < kRepetitions; ++r) {
    for (size_t k = 0; k < runs.size(); ++k) {
      ChartPoint& point = runs[k].point;
      if (!point.failure.empty() || (!runs[k].point.peer.empty() && r > 0 && times[k][0] > 50.0)) {
        continue;  // seconds more would not move what is so far off
      }
      const Outcome outcome = runs[k].run();
      times[k].push_back(outcome.milliseconds);
      if (outcome.held.empty()) {
        point.failure = "it did not reach half the height";
        continue;
      }
      point.volume_error = outcome.volume_error;
      point.percent =
          100.0 *
          distance_to_octant(centred(points_of(outcome.held), outcome.held.size()), truth).mean;
    }
  }
  for (size_t k = 0; k < runs.size(); ++k) {
    if (runs[k].point.failure.empty()) runs[k].point.milliseconds = median(times[k]);
  }
}

Table table_of(const Chart& chart) {
  Table table{"ball.csv",
              "",
              "",
              {"method", "cpu_ms_per_frame", "percent_of_radius_from_neo_hookean", "volume_error"},
              {}};
  for (const ChartPoint& point : chart.points) {
    table.rows.push_back({point_name(point), "failed", "", ""});
    if (!point.failure.empty()) continue;
    table.rows.back() = {point_name(point), number(point.milliseconds, 4), number(point.percent, 4),
                         number(point.volume_error)};
  }
  return table;
}

}  // namespace

void draw_ball_chart(const fs::path& scenes, const fs::path& out) {
  std::vector<Run> runs = our_runs(scenes);
  const Model model = build_model(read_scene(scenes / "ball.toml", {"scene.frames=1-46"}));
  for (Run& run : bullet_runs(model)) runs.push_back(std::move(run));
  runs.push_back(fem_run(model));
  measure(runs);
  Chart chart;
  chart.scene = "squeezed ball";
  chart.muscles = 1;
  chart.nodes = static_cast<int>(model.muscles[0].rest.vertices.size());
  chart.frames = kHalfHeight;
  for (const Run& run : runs) chart.points.push_back(run.point);
  fs::create_directories(out);
  const auto draw = [&](const char* name, double ChartPoint::*error, const std::string& what) {
    const fs::path svg = out / (std::string(name) + ".svg");
    replace_durably(svg, draw_cost(chart, error, what));
    write_picture(out / (std::string(name) + ".png"), svg);
  };
  draw("ball", &ChartPoint::percent, "% of the radius off a neo-Hookean ball");
  draw("ball_volume", &ChartPoint::volume_error, "largest volume error");
  replace_durably(out / "ball.csv", csv_of(table_of(chart)));
}

}  // namespace thew::tools
