// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/paper/run.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "tools/base/signals.h"
#include "tools/lab/base/play.h"

namespace thew::tools {
namespace {

double deepest_in_bones(const Model& model, const State& state) {
  double deepest = 0.0;
  for (size_t b = 0; b < model.bones.size(); ++b) {
    for (int m = 0; m < state.count(); ++m) {
      for (size_t i = 0; i < state.muscles[m].x.size(); ++i) {
        if (model.muscles[m].driven[i]) continue;
        const ClosestPoint at =
            closest_point(model.surfaces[model.muscles.size() + b].surface, state.bones[b].bvh,
                          state.bones[b].x, to_vec(state.muscles[m].x[i]), 0.01);
        if (at.triangle >= 0) deepest = std::max(deepest, -at.distance);
      }
    }
  }
  return deepest;
}

void note_frame(int frame, const PaperAsk& ask, State& state, PaperRun& run) {
  run.frames.push_back(frame);
  for (int m = 0; m < state.count(); ++m) {
    const Muscle& muscle = run.model->muscles[m];
    const double ratio =
        enclosed_volume(state.muscles[m].x, muscle.rest.triangles) / muscle.rest_volume;
    if (m == 0) run.volume.push_back(ratio);
    run.volume_errors[m] = std::max(run.volume_errors[m], std::abs(ratio - 1.0));
    run.volume_error = std::max(run.volume_error, run.volume_errors[m]);
  }
  run.zone_radius.push_back(state.muscles[0].zone_radius);
  if (ask.measures) {
    Parallel one(1);
    refit_all(*run.model, one, state);
    run.penetration = std::max(run.penetration, deepest_in_bones(*run.model, state));
  }
  if (std::find(ask.keep.begin(), ask.keep.end(), frame) != ask.keep.end()) {
    run.kept.emplace(frame, state);
  }
}

}  // namespace

std::vector<Vec3> points_of(const Points& rows) {
  std::vector<Vec3> points;
  for (const Point& row : rows) points.push_back(to_vec(row));
  return points;
}

PaperScene ready_scene(const PaperAsk& ask) {
  const auto of = std::make_shared<Scene>(read_scene(ask.scene, ask.overrides));
  const auto model = std::make_shared<Model>(build_model(*of));
  model->solver.rungs = false;  // a yardstick that fails is to be seen failing
  return {ask, of, model, settled_state(*model)};
}

PaperRun run_scene(const PaperAsk& ask) { return run_scene(ready_scene(ask)); }

PaperRun run_scene(const PaperScene& ready) {
  const PaperAsk& ask = ready.ask;
  PaperRun run;
  run.scene = ready.scene;
  run.model = ready.model;
  run.volume_errors.assign(ready.start.count(), 0.0);
  const int first = ready.model->first_frame;
  const int frames = (ask.last > 0 ? ask.last : ready.model->last_frame) - first;
  Played played = play(*ready.model, ready.start, ask.last, [&](int frame, State& state) {
    note_frame(frame, ask, state, run);
    if (frame == first) return;
    for (const double push : state.muscles[0].normal_multiplier) {
      run.pressing += (push > 0.0 ? 1.0 : 0.0) / frames;
    }
  });
  run.seconds = played.seconds / frames;
  run.state = std::move(played.state);
  return run;
}

std::vector<double> time_scenes(const std::vector<PaperScene>& scenes, int repetitions,
                                const std::function<void()>& on_run) {
  // By scene, frame, repetition.
  std::vector<std::vector<std::vector<double>>> frames(scenes.size());
  Parallel one(1);
  StageSeconds stages;
  for (int r = 0; r < repetitions; ++r) {
    std::vector<State> states;
    for (const PaperScene& scene : scenes) states.push_back(scene.start);
    size_t left = scenes.size();
    for (size_t f = 0; left > 0; ++f) {
      stop_if_interrupted();
      for (size_t k = 0; k < scenes.size(); ++k) {
        const Scene& scene = *scenes[k].scene;
        const int last = scenes[k].ask.last > 0 ? scenes[k].ask.last : scene.last_frame;
        const size_t count = last - scene.first_frame;
        if (f >= count) continue;
        if (r == 0) frames[k].emplace_back();
        const double begin = cpu_seconds();
        step_frame(*scenes[k].model, (f + 1) / scene.fps, one, states[k], stages);
        frames[k][f].push_back(cpu_seconds() - begin);
        if (f + 1 < count) continue;
        --left;
        on_run();
      }
    }
  }
  std::vector<double> means;
  for (const auto& by_frame : frames) {
    double sum = 0.0;
    for (const std::vector<double>& values : by_frame) sum += median(values);
    means.push_back(sum / by_frame.size());
  }
  return means;
}

namespace {

SceneView view_of(const Scene& scene, const std::string& name) {
  for (const SceneView& view : scene.render.views) {
    if (name.empty() || view.name == name) return view;
  }
  throw Error(ErrorCode::kUsage, scene.file.string() + ": has no view \"" + name + "\"");
}

}  // namespace

PaperPicture picture_of(const PaperRun& run, const State& state, const PaperView& view) {
  const Scene& scene = *run.scene;
  const Model& model = *run.model;
  const BakeInfo info = bake_info(model, {});
  PaperPicture picture{scene.render.width, scene.render.height, view_of(scene, view.name), {}, {}};
  if (view.weights || !view.values.empty()) picture.view.show = "weights";
  for (size_t i = 0; i < info.meshes.size(); ++i) {
    BakeMesh mesh = info.meshes[i];
    if (mesh.kind == BakeMesh::Kind::kBone && !view.bones) continue;
    const size_t muscles = model.muscles.size(), b = i - muscles;
    if (i < muscles) {
      mesh.weights = i == 0 && !view.values.empty() ? view.values : state.muscles[i].weights;
      const double most = *std::max_element(mesh.weights.begin(), mesh.weights.end());
      for (double& w : mesh.weights) w /= std::max(most, 1e-30);
    }
    picture.meshes.push_back(std::move(mesh));
    picture.positions.push_back(points_of(i < muscles              ? state.muscles[i].x
                                          : b < model.bones.size() ? state.bones[b].x
                                                                   : state.skin.x));
  }
  return picture;
}

PaperPicture picture_of(const Scene& scene, const TriMesh& mesh) {
  return {scene.render.width,
          scene.render.height,
          view_of(scene, ""),
          {{"body", BakeMesh::Kind::kMuscle, mesh, {}, {}}},
          {mesh.vertices}};
}

}  // namespace thew::tools
