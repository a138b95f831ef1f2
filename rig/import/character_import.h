// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/character.h"

namespace thew::rig {

/// Whether the ending of the file is that of a character (gltf, glb, vrm, fbx, dae), or of a motion
/// of bodies (the same, and bvh).
bool names_character(const std::filesystem::path& file);
bool names_motion(const std::filesystem::path& file);

/// Reads skeleton, skin and animations of a glTF, FBX or Collada file, or skeleton and motion of a
/// BVH, in a child process. `scale` multiplies all lengths of the file. Throws Error(kInput) with
/// the file, the cause and what the user can do.
Character import_character(const std::filesystem::path& file, double scale = 1.0);
/// The same for skeleton and animations alone. The file needs no mesh, and its positions have no
/// unit.
Character import_motion(const std::filesystem::path& file);

/// A number for each vertex of a character from its glTF file: of a custom attribute
/// ("_THEW_FAT"), or with a `channel` (0 to 3; else -1) of colours ("COLOR_0"). Vertices of parts
/// that lack it get NaN. Throws Error(kInput) where all do.
std::vector<double> import_attribute(const std::filesystem::path& file, const std::string& name,
                                     int channel, const Character& of);

}  // namespace thew::rig
