// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/build_model.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// Reads the rig, meshes and motions that the scene names. Throws Error with file, cause and next
/// move.
ModelDef define_model(const Scene& scene);
Model build_model(const Scene& scene);

/// The integrator that a scene calls so in solver.integrator.
Integrator integrator_of(const std::string& word);

}  // namespace thew::sim
