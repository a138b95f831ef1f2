// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "rig/character.h"

namespace thew {

// Private to the library; to be called in a child process (child.h).

/// assimp takes all curves of a glTF for straight lines between their keys. Puts those that are
/// STEP or CUBICSPLINE in their place (glTF 2.0, appendix C). `body_of` tells the body of a node's
/// name, -1 for none; lengths of the first body are multiplied by `scale`. What cannot be read
/// stays as assimp has it, with a warning.
void mend_gltf_curves(const std::filesystem::path& file, double scale,
                      const std::function<int(const std::string&)>& body_of, Character& character);

}  // namespace thew
