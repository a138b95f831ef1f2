// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/import/mesh_import.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// The weights of a muscle's nodes as its scene gives them: as a list, by nearest point, by colour,
/// or by a profile at the nodes' coordinates `u`. One number of 0 or more for each node; swelling
/// and volume correction both go by it. `location` begins each message.
std::vector<double> authored_weights(const SceneMuscle& scene, const TriMesh& rest,
                                     const std::vector<double>& u, const ImportedMesh& imported,
                                     const std::string& location);

}  // namespace thew::sim
