// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/peers/bar_chart.h"

#include <cmath>

#include "sim/cache/durable_file.h"
#include "sim/solver/muscle_step.h"
#include "tools/base/options.h"
#include "tools/lab/base/searched_mesh.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/run.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kFinest = 3;  // from there on two_bellies moves by 0.2 mm

BarRun measure(const PaperRun& run, const SearchedMesh& truth) {
  const Muscle& muscle = run.model->muscles[0];
  const MuscleState& now = run.state.muscles[0];
  const std::vector<Vec3> x = points_of(now.x);
  BarRun out;
  out.nodes = static_cast<int>(x.size());
  out.frames = static_cast<int>(run.frames.size());
  out.volume_error = run.volume_error;
  out.zone_fallbacks = now.zone_fallbacks;
  out.free_half = free_half(muscle.rest, x) / free_half(muscle.rest, muscle.rest.vertices) - 1.0;
  if (muscle.zones.count() > 0) {
    std::vector<double> wanted, found;
    zone_targets(muscle, now.target, wanted);
    volumes_before(muscle.zones, now.x, muscle.rest.triangles, found);
    out.zone_error = zone_error(muscle.zones, found, wanted);
  }
  int squeezed = 0, free = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (muscle.driven[i]) continue;
    const Vec3 p(x[i].x(), std::abs(x[i].y()), std::abs(x[i].z()));  // the truth is a quarter
    const double off = (truth.nearest(p, 1.0).point - p).norm();
    const bool is_free = muscle.rest.vertices[i].x() > 0.0;
    (is_free ? out.free_mean : out.squeezed_mean) += off;
    ++(is_free ? free : squeezed);
    out.largest = std::max(out.largest, off);
  }
  out.mean = (out.free_mean + out.squeezed_mean) / (free + squeezed);
  out.free_mean /= free;
  out.squeezed_mean /= squeezed;
  return out;
}

struct Bar {
  std::string name, mesh;
  BarShape shape;
};

// Of one multiplier, and of zones: what they are called, and their settings.
struct Held {
  std::string name;
  std::vector<std::string> settings;
};
const std::vector<Held> kHeld = {
    {"none", {"solver.volume=none"}},           {"exact", {"solver.volume=exact"}},
    {"zonal, 2 zones", {"muscle.bar.zones=2"}}, {"zonal, 4 zones", {"muscle.bar.zones=4"}},
    {"zonal, 8 zones", {"muscle.bar.zones=8"}},
};

using Row = std::vector<std::string>;

Row row_of(const std::string& bar, const std::string& name, const BarRun& run) {
  return {bar,
          name,
          number(run.milliseconds),
          number(1e3 * run.mean),
          number(1e3 * run.largest),
          number(1e3 * run.squeezed_mean),
          number(1e3 * run.free_mean),
          number(100.0 * run.free_half),
          number(run.volume_error, 2),
          number(run.zone_error, 2),
          std::to_string(run.zone_fallbacks)};
}

// The true surface too encloses more in its free half: the inside flows farther than the rim.
Row true_row(const std::string& bar, const TrueBar& truth) {
  const TriMesh rest = octant_surface(truth.rest), now = octant_surface(truth.squeezed);
  const double grown = free_half(rest, now.vertices) / free_half(rest, rest.vertices) - 1.0;
  const double error = std::abs(fem_volume(truth.squeezed) / fem_volume(truth.rest) - 1.0);
  return {bar, "finite elements", "", "", "", "", "", number(100.0 * grown), number(error, 2), "",
          ""};
}

}  // namespace

TrueBar squeeze_true_bar(const BarShape& shape, int n) {
  constexpr int kAlong = 9;  // elements along for each across: they are squarish
  TrueBar bar;
  bar.rest =
      quarter_bar(shape, n, kAlong * n, {.neo_hookean = true, .shear = 1000.0, .penalty = 1e6});
  bar.squeezed = bar.rest;
  bar.result = squeeze_bar(shape, 16, bar.squeezed);
  return bar;
}

double free_half(const TriMesh& rest, const std::vector<Vec3>& x) {
  constexpr double kRounding = 1e-6;  // m, of the meshes' files
  Vec3 tip = Vec3::Zero();
  double rim = 0.0;
  for (const Triangle& t : rest.triangles) {
    for (int i : t) {
      if (std::abs(rest.vertices[i].x()) > kRounding) continue;
      tip.x() += x[i].x();
      rim += 1.0;
    }
  }
  tip /= rim;
  double volume = 0.0;
  for (const auto& [i, j, k] : rest.triangles) {
    if (std::min({rest.vertices[i].x(), rest.vertices[j].x(), rest.vertices[k].x()}) < -kRounding) {
      continue;
    }
    volume += (x[i] - tip).dot((x[j] - tip).cross(x[k] - tip)) / 6.0;
  }
  return volume;
}

std::vector<BarRun> run_bars(const fs::path& scene,
                             const std::vector<std::vector<std::string>>& overrides,
                             int repetitions, const TrueBar& truth) {
  const SearchedMesh surface(octant_surface(truth.squeezed));
  std::vector<PaperScene> scenes;
  for (const auto& more : overrides) scenes.push_back(ready_scene({scene, more, 0, {}, false}));
  std::vector<BarRun> runs;
  for (const PaperScene& ready : scenes) runs.push_back(measure(run_scene(ready), surface));
  if (repetitions == 0) return runs;
  const std::vector<double> seconds = time_scenes(scenes, repetitions, [] {});
  for (size_t k = 0; k < runs.size(); ++k) runs[k].milliseconds = 1e3 * seconds[k];
  return runs;
}

namespace {

// Of one bar, the stand-in for its inside taken away where it is hollow. Adds the table's rows.
void draw_bar(const Bar& bar, bool hollow, const TrueBar& truth, const fs::path& out,
              Table& table) {
  constexpr int kRepetitions = 3;
  const std::string name = bar.name + (hollow ? "_hollow" : "");
  std::vector<std::vector<std::string>> asks;
  for (const Held& held : kHeld) {
    asks.push_back(held.settings);
    asks.back().push_back("muscle.bar.mesh=" + bar.mesh);
    if (hollow) asks.back().push_back("muscle.bar.material.shape=0");
  }
  const std::vector<BarRun> runs = run_bars(own_asset("paper/bar.toml"), asks, kRepetitions, truth);
  Chart chart;
  chart.scene = name;
  chart.muscles = 1;
  chart.nodes = runs[0].nodes;
  chart.frames = runs[0].frames;
  for (size_t k = 0; k < runs.size(); ++k) {
    table.rows.push_back(row_of(name, kHeld[k].name, runs[k]));
    ChartPoint& point = chart.points.emplace_back();
    point.setting = {"local_global", kHeld[k].name, 1, 20};
    point.is_default = kHeld[k].name == "zonal, 4 zones";
    point.milliseconds = runs[k].milliseconds;
    point.percent = 100.0 * runs[k].mean / bar.shape.half.y();
  }
  const fs::path svg = out / (name + ".svg");
  replace_durably(svg,
                  draw_cost(chart, &ChartPoint::percent, "% of half the thickness off elements"));
  write_picture(out / (name + ".png"), svg);
}

}  // namespace

Table draw_bar_chart(const fs::path& out) {
  Table table{
      "bar.csv",
      "A bar half of which plates press, beside neo-Hookean finite elements",
      "Distances in mm, the mean and the largest, over all nodes, those of the pressed half "
      "and those of the free half; how much more the free half holds.",
      {"bar", "volume", "CPU ms a frame", "mean, mm", "largest, mm", "pressed half, mm",
       "free half, mm", "free half, %", "volume error", "zone error", "zone fallbacks"},
      {}};
  fs::create_directories(out);
  for (const Bar& bar :
       {Bar{"two_bellies", "two_bellies.obj", {.neck = kNeck}}, Bar{"spindle", "bar.obj", {}}}) {
    const TrueBar truth = squeeze_true_bar(bar.shape, kFinest);
    if (!truth.result.converged) {
      throw Error(ErrorCode::kSolver, "the neo-Hookean bar did not converge");
    }
    table.rows.push_back(true_row(bar.name, truth));
    for (bool hollow : {false, true}) draw_bar(bar, hollow, truth, out, table);
  }
  replace_durably(out / table.file, csv_of(table));
  return table;
}

}  // namespace thew::tools
