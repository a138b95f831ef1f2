// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/export/character_skin.h"
#include "tools/export/gltf/glb.h"

namespace thew::tools {

/// Transforms of bodies by frame and body.
using World = std::vector<std::vector<Affine>>;

/// Adds keys of all nodes that move, at the times of an accessor, and returns where a reader of the
/// file finds the bodies.
World animate_bodies(const CharacterSkin& skin, std::size_t times, Glb& glb,
                     nlohmann::ordered_json& animation);

}  // namespace thew::tools
