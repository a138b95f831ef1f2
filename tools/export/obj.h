// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// By chosen mesh the text of an OBJ file that all frames share: texture coordinates and faces,
/// with a group and a material of the mesh's kind, and those of its character's materials.
std::vector<std::string> obj_faces(const Shot& shot);

/// The shot's meshes at `positions` (by chosen mesh) as the text of an OBJ file: one object each,
/// vertices and normals in their order, all digits of the bake's precision.
std::string obj_text(const Shot& shot, const std::vector<std::string>& faces,
                     const std::vector<std::vector<Vec3>>& positions);

}  // namespace thew::tools
