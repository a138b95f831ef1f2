// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/character.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// Reads nodes, skins, meshes, animations and VRM's bones of a glTF 2.0 file, all lengths
/// multiplied by `scale`. Of the skeleton only names and parents are set; the caller makes its
/// frames from `bind`. Throws Error(kInput) if the file is not sound, or has no mesh and
/// `with_mesh` is true.
Character read_gltf_character(const std::filesystem::path& file, double scale, bool with_mesh);

}  // namespace thew::rig
