// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/character.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// Whether the file's ending is glTF's: gltf, glb or vrm.
bool names_gltf(const std::filesystem::path& file);

/// A character as glTF 2.0 has it: nodes, skins, meshes, animations, VRM's bones. The frames of
/// the skeleton come from `bind`. In metres times `scale`. `with_mesh`: without one it is
/// Error(kInput).
Character read_gltf_character(const std::filesystem::path& file, double scale, bool with_mesh);

}  // namespace thew::rig
