// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace thew::tools {

/// A map of a scene, on its mesh.
struct DrawnMap {
  std::string mesh, quantity;
  double least = 0.0, most = 0.0;  ///< of its values
  std::filesystem::path picture;
};

/// Draws the weights of all muscles and all other maps that are not one number everywhere, each as
/// FOLDER/MESH.QUANTITY.png with a scale of its colours.
std::vector<DrawnMap> draw_maps(const Scene& scene, const std::filesystem::path& folder,
                                bool overwrite);

}  // namespace thew::tools
