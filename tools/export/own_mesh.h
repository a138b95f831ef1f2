// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tools/export/shot.h"

namespace thew::tools {

/// Puts the skin of the shot onto `file`, an OBJ of it or of a part of it, as the program has
/// written it that the mesh is from: from then on the skin has that file's vertices in their order,
/// its polygons, texture coordinates and groups of material. The file has the skin in the bind pose
/// of `character`, the file of the bake's character, or, also where that is "", as the bake has it
/// at rest. A vertex of it is the bake's at its place, within 1e-5 m, the first of several. Its
/// lengths are metres, those of the character, or a hundredth of either. Error(kInput) with line or
/// vertex where it is no such OBJ, Error(kUsage) where the bake has no skin.
void put_onto_own_mesh(const std::filesystem::path& file, const std::filesystem::path& character,
                       Shot& shot);

}  // namespace thew::tools
