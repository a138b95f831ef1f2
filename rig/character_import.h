// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/character.h"

namespace thew {

/// Whether the file's ending is that of a character: gltf, glb, fbx or dae.
bool names_character(const std::filesystem::path& file);

/// Reads skeleton, skin and animations of a glTF, FBX or Collada file, or skeleton and motion of a
/// BVH, through assimp in a child process. `scale` multiplies all lengths of the file. Throws
/// Error(kInput) with file, cause and next move.
Character import_character(const std::filesystem::path& file, double scale = 1.0);

}  // namespace thew
