// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/character.h"
#include "rig/import/gltf_file.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// Reads the animations of a glTF: LINEAR, STEP and CUBICSPLINE curves (glTF 2.0, appendix C). A
/// curve of another interpolation is read as a linear one, with a warning. `body` has the body of
/// each node, -1 for none; lengths of body 0, the root, are multiplied by `scale`.
void read_gltf_animations(GltfFile& gltf, const std::vector<int>& body, double scale,
                          Character& character);

}  // namespace thew::rig
