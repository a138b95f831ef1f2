// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "thew/scene.h"

namespace thew {

// The public types have the plain names (Muscle, Clip). They are included last, since the internal
// headers mean their own by these.

/// What a public Scene holds.
struct SceneData {
  static const SceneData& of(const Scene& scene) { return *scene.data_; }
  static std::shared_ptr<const SceneData> share(const Scene& scene) { return scene.data_; }

  sim::Model model;
  bool double_precision = false;  ///< of a bake
  std::string text = {};          ///< of the scene's file, to say what differs on resuming
  SceneInfo info = {};
};

namespace sim {
/// Error(kUsage) names the part that does not fit.
ModelDef define_model(const SceneDefinition& definition);
}  // namespace sim

}  // namespace thew
