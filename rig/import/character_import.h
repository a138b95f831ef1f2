// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/character.h"

namespace thew::rig {

/// Whether the file's ending is that of a character: gltf, glb, vrm, fbx or dae; or of a motion of
/// bodies: bvh as well.
bool names_character(const std::filesystem::path& file);
bool names_motion(const std::filesystem::path& file);

/// Reads skeleton, skin and animations of a glTF, FBX or Collada file, or skeleton and motion of a
/// BVH, in a child process. `scale` multiplies all lengths of the file. Throws Error(kInput) with
/// file, cause and next move.
Character import_character(const std::filesystem::path& file, double scale = 1.0);
/// The same for its skeleton and animations, whose places have no unit: it needs no mesh.
Character import_motion(const std::filesystem::path& file);

}  // namespace thew::rig
