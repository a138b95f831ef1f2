// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/build_model.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// Reads all that the scene names, rig, meshes and motions. Throws Error with file, cause, next
/// move.
ModelDef define_model(const Scene& scene);
Model build_model(const Scene& scene);

/// Of a scene's solver.integrator.
Integrator integrator_of(const std::string& word);

}  // namespace thew::sim
