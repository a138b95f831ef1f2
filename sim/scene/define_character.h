// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/model_def.h"
#include "sim/scene/scene.h"

namespace thew::sim {

// What a scene says of a rig that is a character's file, with the file read.

/// Sets the skeleton with its hinges, and the clip where it is an animation or a BVH.
CharacterRig define_character(const Scene& scene, Skeleton& skeleton,
                              std::vector<std::string>& warnings);
/// Meshes that the scene gives to bodies of the character.
std::vector<Bone> character_bones(const Scene& scene, const Skeleton& skeleton);

}  // namespace thew::sim
