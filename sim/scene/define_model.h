// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/build_model.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// Reads the rig, meshes and motions that the scene names. Throws Error with file, cause and next
/// move.
ModelDef define_model(const Scene& scene);
Model build_model(const Scene& scene);
/// The same under other keys of [solver] than it was defined with, without reading a file again.
void solve_as(const Scene& scene, ModelDef& def);

/// The integrator that a scene calls so in solver.integrator.
Integrator integrator_of(const std::string& word);

}  // namespace thew::sim
