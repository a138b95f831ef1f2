// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/chart/skin_chart.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include "sim/bake/bake.h"
#include "sim/bake/measure.h"
#include "sim/framing.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "tools/compare/image_metrics.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"
#include "tools/lab/chart/plot.h"
#include "tools/render/contact_sheet.h"
#include "tools/render/gl_context.h"
#include "tools/render/renderer.h"

namespace thew::tools {
namespace {

constexpr int kPictures = 4;  // frames that are drawn, spread over the clip
constexpr SkinSetting kReference = {64, 1, false};

/// What a run leaves: the skin by frame, as the one mesh, and how it stood before the first.
struct SkinRun {
  Frames frames;
  std::optional<State> settled;
};

ModelDef skin_of_scene(const ChartAsk& ask, Scene& scene) {
  scene = read_scene(ask.scene);
  scene.solver.tolerance.reset();
  if (ask.last > 0) scene.last_frame = ask.last;
  return define_model(scene);
}

Model solved(const ModelDef& def, const SkinSetting& setting) {
  ModelDef own = def;
  own.skin.settings.iterations = setting.iterations;
  own.skin.settings.iterations_per_search = setting.iterations_per_search;
  own.skin.settings.keeps_volume = setting.keeps_volume;
  return build_model(own);
}

SkinRun run_skin(const Model& model, const std::function<void(State&)>& on_frame = {}) {
  SkinRun run;
  run.settled = settled_state(model);
  play(model, *run.settled, model.last_frame, [&](int, State& state) {
    run.frames.push_back({state.skin.x});
    if (on_frame) on_frame(state);
  });
  return run;
}

// Runs a setting through the clip and sets its errors.
SkinRun measure_point(const Model& model, const Frames& reference, ChartPoint& point) {
  Parallel one(1);
  std::optional<Measuring> measuring;
  try {
    SkinRun run = run_skin(model, [&](State& state) {
      if (!measuring) measuring = start_measuring(model, initial_state(model));
      const SkinMetrics skin = measure(model, *measuring, one, state).skin;
      point.penetration_mm = std::max(point.penetration_mm,
                                      1e3 * std::max(skin.max_penetration, skin.max_poke_through));
      point.volume_error = std::max(point.volume_error, skin.volume_error);
    });
    const NodeDistance distance = distance_of(run.frames, reference);
    point.largest_mm = distance.largest;
    point.rms_mm = distance.rms();
    return run;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kSolver) throw;
    point.failure = error.what();
    return {};
  }
}

/// Draws the skin in some frames of the clip.
class SkinPictures {
 public:
  SkinPictures(const Scene& scene, const Model& model) {
    const std::vector<SceneView> views = frame_views(model, scene.render);
    const auto view = std::find_if(views.begin(), views.end(),
                                   [](const SceneView& v) { return v.show == "skin"; });
    if (view == views.end()) return;
    view_ = *view;
    first_ = model.first_frame;
    info_ = bake_info(model, {first_});
    set_driver_options();
    renderer_ = std::make_unique<Renderer>(scene.render.width, scene.render.height, info_.meshes);
    indices_ = spread_indices(model.last_frame - first_ + 1, kPictures);
  }

  // None where the scene has no view of the skin.
  std::vector<Image> draw(const Frames& frames) {
    std::vector<Image> images;
    for (const int index : indices_) {
      std::vector<std::vector<Vec3>> positions;  // what is not shown may be as it is at rest
      for (const BakeMesh& mesh : info_.meshes) {
        std::vector<Vec3>& of = positions.emplace_back(mesh.rest.vertices);
        if (mesh.kind != BakeMesh::Kind::kSkin) continue;
        for (std::size_t i = 0; i < of.size(); ++i) of[i] = to_vec(frames[index][0][i]);
      }
      images.push_back(renderer_->draw(view_at(view_, first_ + index), positions));
    }
    return images;
  }

 private:
  SceneView view_;
  int first_ = 0;
  BakeInfo info_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<int> indices_;
};

ChartPoint point_of(const SkinSetting& setting, const SkinSetting& own) {
  ChartPoint point;
  point.is_default = setting == own;
  point.setting.iterations = setting.iterations;
  point.setting.volume = setting.keeps_volume ? "exact" : "none";
  point.label = std::to_string(setting.iterations);
  if (setting.keeps_volume != own.keeps_volume) {
    point.peer = setting.keeps_volume ? "volume held" : "volume let go";
    point.colour = 3;
  } else if (setting.iterations_per_search != own.iterations_per_search) {
    point.peer = "by look-ups";
    point.colour = 1;
    point.label += ", a search in " + std::to_string(setting.iterations_per_search);
  } else {
    point.peer = "by iterations";
    point.colour = 0;
  }
  if (point.is_default) point.label += " (the scene's)";
  return point;
}

}  // namespace

std::vector<SkinSetting> skin_settings(const SkinSetting& own, bool is_layer) {
  std::vector<SkinSetting> settings = {own};
  const auto add = [&](SkinSetting setting) {
    if (std::find(settings.begin(), settings.end(), setting) == settings.end()) {
      settings.push_back(setting);
    }
  };
  for (const int iterations : {1, 2, 3, 4, 6, 8, 12, 16, 24}) {
    add({iterations, own.iterations_per_search, own.keeps_volume});
  }
  for (const int apart : {1, 2, own.iterations}) add({own.iterations, apart, own.keeps_volume});
  if (is_layer) add({own.iterations, own.iterations_per_search, !own.keeps_volume});
  return settings;
}

std::string skin_setting_name(const SkinSetting& setting) {
  return std::to_string(setting.iterations) +
         (setting.iterations == 1 ? " iteration" : " iterations") + ", a search in " +
         std::to_string(setting.iterations_per_search) +
         (setting.keeps_volume ? ", volume held" : "");
}

SkinChart run_skin_chart(const ChartAsk& ask) {
  Scene scene;
  const ModelDef def = skin_of_scene(ask, scene);
  SkinChart out;
  if (def.skin.mesh.vertices.empty() && !def.skin.skinned) return out;
  const SkinSettings& given = def.skin.settings;
  const SkinSetting own = {given.iterations, given.iterations_per_search, given.keeps_volume};
  Chart& chart = out.chart;
  chart.scene = scene.name;
  chart.muscles = static_cast<int>(def.muscles.size());
  chart.frames = scene.last_frame - scene.first_frame + 1;
  chart.repetitions = ask.repetitions;
  chart.timed_frames = std::min(kTimedFrames, chart.frames - 1);
  out.settings = skin_settings(own, !def.skin.skinned);
  out.reference = kReference;
  out.reference.keeps_volume = own.keeps_volume;
  SkinSetting half = out.reference;
  half.iterations /= 2;
  std::vector<Model> models;
  for (const SkinSetting& setting : out.settings) {
    models.push_back(solved(def, setting));
    chart.points.push_back(point_of(setting, own));
  }
  const int points = static_cast<int>(models.size());
  const int total = 2 + (1 + ask.repetitions) * points;
  int done = 0;
  std::mutex one_at_a_time;
  const auto on_run = [&] {
    const std::lock_guard lock(one_at_a_time);
    ask.on_step(++done, total);
  };
  Parallel parallel(ask.threads);
  SkinRun finest[2];
  parallel.each(2, [&](int i) {
    finest[i] = run_skin(solved(def, i == 0 ? out.reference : half));
    on_run();
  });
  const Frames& reference = finest[0].frames;
  out.known_mm = distance_of(finest[1].frames, reference).largest;
  chart.nodes = static_cast<int>(reference.front().front().size());
  std::vector<SkinRun> runs(points);
  parallel.each(points, [&](int k) {
    runs[k] = measure_point(models[k], reference, chart.points[k]);
    on_run();
  });
  out.flip.assign(points, -1.0);
  SkinPictures pictures(scene, models.front());
  const std::vector<Image> expected = pictures.draw(reference);
  for (int k = 0; k < points; ++k) {
    if (!runs[k].settled) continue;
    const std::vector<Image> drawn = pictures.draw(runs[k].frames);
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      out.flip[k] = std::max(out.flip[k], measure_pixels(expected[i], drawn[i], nullptr, 0).flip);
    }
  }
  const auto seconds_of = [&](std::size_t k) {
    return play(models[k], *runs[k].settled, models[k].first_frame + chart.timed_frames).seconds;
  };
  time_points(seconds_of, on_run, chart);
  for (const std::size_t i : pareto_front(chart.points, &ChartPoint::largest_mm)) {
    chart.points[i].on_front = true;
  }
  return out;
}

Table points_of(const SkinChart& skin) {
  Table table{
      "",
      "Each setting of the skin",
      "The whole frame: muscles, contact, skin. Errors are distances of the skin's vertices "
      "from " +
          skin_setting_name(skin.reference) + ", which is itself " + number(skin.known_mm) +
          " mm from half as many. FLIP: mean LDR-FLIP of the worst of " +
          std::to_string(kPictures) +
          " pictures; below 0.01 a picture is taken for unchanged. Front: nothing cheaper "
          "is nearer.",
      {"setting", "CPU ms a frame", "time over the scene's own", "largest, mm", "RMS, mm",
       "flesh through skin or skin in flesh, mm", "volume error", "FLIP", ""},
      {}};
  const Chart& chart = skin.chart;
  const double own = chart.points.empty() ? 0.0 : chart.points.front().milliseconds;
  for (std::size_t k = 0; k < chart.points.size(); ++k) {
    const ChartPoint& point = chart.points[k];
    std::vector<std::string>& row = table.rows.emplace_back(table.head.size());
    row.front() = skin_setting_name(skin.settings[k]) + (point.is_default ? " (the scene's)" : "");
    row.back() = point.failure.empty() ? (point.on_front ? "front" : "") : point.failure;
    if (!point.failure.empty()) continue;
    int column = 0;
    for (const double value :
         {point.milliseconds, own > 0.0 ? point.milliseconds / own : -1.0, point.largest_mm,
          point.rms_mm, point.penetration_mm, point.volume_error, skin.flip[k]}) {
      row[++column] = value >= 0.0 ? number(value) : "";
    }
  }
  return table;
}

std::string html_of(const SkinChart& skin) {
  if (skin.settings.empty()) return "";
  return "<h2>The skin</h2>\n<figure>" +
         draw_cost(skin.chart, &ChartPoint::largest_mm, kSkinError) + "</figure>\n" +
         html_of(points_of(skin));
}

}  // namespace thew::tools
