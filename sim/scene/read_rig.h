// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/scene.h"
#include "sim/scene/values.h"

namespace thew::sim {

// What [rig] has for a character's file besides what it has for a URDF.

/// [rig] scale, [[rig.hinge]], [[rig.bone]].
/// Of [rig], where its bones come from a cache: scene.rig is a bake, or empty.
void read_cached_rig(TomlValue& table, const Folders& folders, Scene& scene);
SceneCollider read_collider(TomlValue& table, const Folders& folders);
/// The frame that a key gives.
std::optional<double> read_frame(TomlValue& table, const Key& key);
void read_character_rig(TomlValue& table, const Folders& folders, Scene& scene);
/// [rig.clip] with an animation of the character or a BVH; false where it is another clip.
bool read_character_clip(TomlValue& table, const Folders& folders, Scene& scene);

}  // namespace thew::sim
