// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/scene.h"
#include "sim/scene/values.h"

namespace thew::sim {

// What [rig] has for a character's file besides what it has for a URDF.

/// [rig] scale, [[rig.hinge]], [[rig.bone]].
void read_character_rig(TomlValue& table, const Folders& folders, Scene& scene);
/// [rig.clip] with an animation of the character or a BVH; false where it is another clip.
bool read_character_clip(TomlValue& table, const Folders& folders, Scene& scene);

}  // namespace thew::sim
