// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/character.h"
#include "rig/import/gltf_file.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// The animations of a glTF: linear, STEP and CUBICSPLINE curves (glTF 2.0, appendix C). A curve of
/// another interpolation is taken for a linear one, with a warning. `body` tells the body of a
/// node, -1 for none; lengths of the first body are multiplied by `scale`.
void read_gltf_animations(GltfFile& gltf, const std::vector<int>& body, double scale,
                          Character& character);

}  // namespace thew::rig
