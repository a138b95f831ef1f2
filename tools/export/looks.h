// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tools/export/shot.h"

namespace thew::tools {

/// Of a muscle whose bake knows where its nodes lie along and about its path: u goes once around,
/// v from the origin, 0, to the insertion, 1, so that fibres are lines of equal u.
Uvs fibre_uvs(const BakeMesh& mesh);
/// Those of the shot's m-th mesh, muscle or skin; faces are triangles but where the skin's own mesh
/// has others.
Faces faces_of(const Shot& shot, std::size_t m);
Uvs uvs_of(const Shot& shot, std::size_t m);

/// What the character's own file knows of the bake's skin. Error(kInput) where it is not the
/// character of the bake.
SkinLooks read_skin_looks(const Shot& shot, const std::filesystem::path& character);

}  // namespace thew::tools
