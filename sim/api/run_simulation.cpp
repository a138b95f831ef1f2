// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rig/api/arrays.h"
#include "rig/text.h"
#include "sim/api/scene_data.h"
#include "sim/lone_frame.h"
#include "sim/solver/state_archive.h"
#include "thew/simulation.h"

namespace thew {

struct Simulation::Data {
  Data(const Scene& of, int threads)
      : scene(SceneData::share(of)),
        planned(plan(scene->model, threads)),
        model(planned ? *planned : scene->model),
        info(sim::bake_info(model, {})),
        parallel(threads),
        state(sim::initial_state(model)),
        measuring(sim::start_measuring(model, state)) {}

  // A tolerance is met by a model of its own.
  static std::unique_ptr<const sim::Model> plan(const sim::Model& model, int threads) {
    if (!model.solver.tolerance || model.fidelity) return nullptr;
    auto out = std::make_unique<sim::Model>(model);
    out->fidelity = sim::plan_fidelity(model, threads).fidelity;
    return out;
  }

  void settle() {
    if (settled) return;
    if (alone) {
      go_to(0.0);
    } else {
      sim::settle(model, parallel, state);
    }
    settled = true;
  }

  void go_to(double time) {
    if (alone) {
      sim::solve_lone_frame(model, time, parallel, state, seconds);
    } else {
      sim::step_frame(model, time, parallel, state, seconds);
    }
  }

  std::size_t place_of(const std::string& mesh) const {
    const std::vector<std::string>& names = scene->info.meshes;
    const auto found = std::find(names.begin(), names.end(), mesh);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    throw Error(ErrorCode::kUsage, scene->info.name + ": there is no mesh \"" + mesh + "\"" +
                                       rig::did_you_mean(mesh, names));
  }

  // In the order of SceneInfo::meshes, which is that of a bake's.
  std::vector<rig::Vec3> positions(std::size_t mesh) const {
    const std::size_t muscles = state.muscles.size(), bones = state.bones.size();
    const rig::Points& x = mesh < muscles           ? state.muscles[mesh].x
                           : mesh < muscles + bones ? state.bones[mesh - muscles].x
                                                    : state.skin.x;
    std::vector<rig::Vec3> points;
    points.reserve(x.size());
    for (const rig::Point& row : x) points.push_back(rig::to_vec(row));
    return mesh < muscles ? rig::in_file_order(model.muscles[mesh].order, std::move(points))
                          : points;
  }

  std::shared_ptr<const SceneData> scene;
  std::unique_ptr<const sim::Model> planned;
  const sim::Model& model;
  sim::BakeInfo info;
  sim::Parallel parallel;
  sim::State state;
  sim::Measuring measuring;
  sim::StageSeconds seconds;
  bool alone = sim::stands_alone(model);
  bool settled = false;
};

Simulation::Simulation(const Scene& scene, int threads)
    : data_(std::make_unique<Data>(scene, threads)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

void Simulation::settle() { data_->settle(); }

int Simulation::step() {
  Data& data = *data_;
  data.settle();
  // The times of a bake, to the last bit.
  const int next = static_cast<int>(std::floor(data.state.time * data.model.fps + 1e-6)) + 1;
  data.go_to(next / data.model.fps);
  return data.model.first_frame + next;
}

void Simulation::step_to(double time) {
  Data& data = *data_;
  data.settle();
  if (!(time > data.state.time) || !std::isfinite(time)) {
    throw Error(ErrorCode::kUsage, data.scene->info.name + ": it cannot be stepped to " +
                                       std::to_string(time) + " s, since it is at " +
                                       std::to_string(data.state.time) + " s; give a later time");
  }
  const double frame = 1.0 / data.model.fps;
  while (!data.alone && time - data.state.time > frame * (1.0 + 1e-6)) step();
  if (time > data.state.time) data.go_to(time);
}

double Simulation::time() const { return data_->state.time; }

std::vector<double> Simulation::positions(const std::string& mesh) const {
  return rig::to_array(data_->positions(data_->place_of(mesh)));
}

std::vector<int> Simulation::triangles(const std::string& mesh) const {
  return rig::to_array(data_->info.meshes[data_->place_of(mesh)].rest.triangles);
}

std::vector<double> Simulation::joints() const {
  const rig::Skeleton& skeleton = data_->model.skeleton;
  std::vector<double> values;
  for (int i = 0; i < skeleton.size(); ++i) {
    if (skeleton.joint_types[i] == rig::Skeleton::JointType::kFixed) continue;
    values.push_back(data_->state.joints[i]);
  }
  return values;
}

std::map<std::string, double> Simulation::measures() {
  Data& data = *data_;
  sim::FrameMeasures measures = sim::measure(data.model, data.measuring, data.parallel, data.state);
  std::vector<std::vector<rig::Vec3>> positions;
  for (std::size_t m = 0; m < data.info.meshes.size(); ++m) positions.push_back(data.positions(m));
  sim::measure_written(data.model, data.info, positions, measures);
  const std::vector<double> values = sim::flatten(measures);
  std::map<std::string, double> named;
  for (std::size_t k = 0; k < values.size(); ++k) named[data.info.metric_names[k]] = values[k];
  return named;
}

}  // namespace thew
