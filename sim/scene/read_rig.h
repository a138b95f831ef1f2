// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/scene.h"
#include "sim/scene/values.h"

namespace thew::sim {

// What a rig that is a character's file has beside a URDF: scale, hinges, bones, its animations.

/// [rig] scale, [[rig.hinge]], [[rig.bone]].
void read_character_rig(TomlValue& table, const Folders& folders, Scene& scene);
/// [rig.clip] with an animation of the character or a BVH; false where it is another clip.
bool read_character_clip(TomlValue& table, const Folders& folders, Scene& scene);

}  // namespace thew::sim
