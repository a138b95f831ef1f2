// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/mesh_import.h"
#include "sim/scene.h"

namespace thew {

/// Weights of a muscle's nodes from a list, from places or from colours, before they are tapered;
/// empty where the scene gives a profile. `place` begins each message.
std::vector<double> authored_weights(const SceneMuscle& scene, const TriMesh& rest,
                                     const ImportedMesh& imported, const std::string& place);

}  // namespace thew
