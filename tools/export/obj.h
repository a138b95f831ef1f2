// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// The shot's meshes at `positions` (by chosen mesh) as the text of an OBJ file: one object each,
/// vertices and normals in their order. All digits of the bake's precision.
std::string obj_text(const Shot& shot, const std::vector<std::vector<Vec3>>& positions);

}  // namespace thew::tools
