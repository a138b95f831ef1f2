// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"
#include "tools/lab/bench/benches.h"

namespace thew::tools {
namespace {

using Json = nlohmann::ordered_json;

// Each takes what it is called by out of a scene, and says whether there was any.
bool without_maps(ModelDef& def) {
  bool any = !def.contact.thicknesses.empty() || def.skin.maps.fat.size() > 0;
  for (const double slide : def.skin.maps.slide) any |= slide != 1.0;
  for (MuscleDef& muscle : def.muscles) {
    any |= !muscle.stiffness.empty();
    muscle.stiffness.clear();
  }
  def.contact.thicknesses.clear();
  def.skin.maps = {};
  return any;
}

bool without_activation(ModelDef& def) {
  bool any = false;
  for (MuscleDef& muscle : def.muscles) {
    any |= muscle.by_joint.has_value() || !muscle.activation.empty();
    muscle.by_joint.reset();
    muscle.activation.clear();
  }
  return any;
}

bool without_props(ModelDef& def) {
  return std::erase_if(def.bones, [](const Bone& bone) { return bone.prop; }) > 0;
}

}  // namespace

Json price_of_features(const std::string& scene, int repetitions) {
  struct Feature {
    const char* name;
    bool (*take_out)(ModelDef&);
    Model without = {};
    std::vector<double> milliseconds = {};
  };
  const ModelDef def = define_model(read_scene(scene));
  const Model whole = build_model(def);
  std::vector<Feature> features;
  for (Feature feature : {Feature{"maps", without_maps}, Feature{"activation", without_activation},
                          Feature{"props", without_props}}) {
    ModelDef less = def;
    if (!feature.take_out(less)) continue;
    feature.without = build_model(less);
    features.push_back(std::move(feature));
  }
  if (features.empty()) {
    throw Error(ErrorCode::kInput, scene + ": has no map, activation or prop");
  }
  std::vector<double> milliseconds;
  const auto time_of = [](const Model& model) {
    return play(model, settled_state(model)).milliseconds_a_frame(model);
  };
  for (int i = 0; i < repetitions; ++i) {
    milliseconds.push_back(time_of(whole));
    for (Feature& feature : features) feature.milliseconds.push_back(time_of(feature.without));
  }
  Json out = {{"scene", whole.name}, {"cpu_ms_per_frame", median(milliseconds)}};
  for (const Feature& feature : features) {
    out[std::string("ratio_of_") + feature.name] =
        median(milliseconds) / median(feature.milliseconds);
  }
  return out;
}

}  // namespace thew::tools
