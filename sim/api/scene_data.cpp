// SPDX-License-Identifier: Apache-2.0
#include "sim/api/scene_data.h"

#include "rig/text.h"
#include "sim/cache/version.h"
#include "thew/thew.h"

namespace thew {
namespace {

constexpr std::size_t kLongestScene = std::size_t{4} << 20;  // bytes, as it was read

SceneInfo info_of(const sim::Model& model) {
  SceneInfo info;
  info.name = model.name;
  info.fps = model.fps;
  info.first_frame = model.first_frame;
  info.last_frame = model.last_frame;
  for (int i = 0; i < model.skeleton.size(); ++i) {
    if (model.skeleton.joint_types[i] == sim::Skeleton::JointType::kFixed) continue;
    info.joints.push_back(model.skeleton.joint_names[i]);
  }
  for (const sim::Muscle& muscle : model.muscles) info.meshes.push_back(muscle.name);
  for (const sim::Bone& bone : model.bones) info.meshes.push_back(bone.name);
  if (model.has_skin) info.meshes.emplace_back("skin");
  info.warnings = model.warnings;
  for (const std::string& line : sim::rest_overlaps(model)) {
    info.warnings.push_back(model.source + ": " + line);
  }
  return info;
}

std::shared_ptr<const SceneData> complete(SceneData data) {
  data.info = info_of(data.model);
  return std::make_shared<const SceneData>(std::move(data));
}

}  // namespace

Scene Scene::read(const std::filesystem::path& file, const std::vector<std::string>& settings) {
  const sim::Scene scene = sim::read_scene(file, settings);
  return Scene(complete({sim::build_model(scene), scene.output.double_precision,
                         sim::read_whole(scene.file, kLongestScene)}));
}

Scene::Scene(const SceneDefinition& definition)
    : data_(complete({sim::build_model(sim::define_model(definition))})) {}

Scene::Scene(std::shared_ptr<const SceneData> data) : data_(std::move(data)) {}

const SceneInfo& Scene::info() const { return data_->info; }

const char* version() { return sim::kVersion; }

}  // namespace thew
