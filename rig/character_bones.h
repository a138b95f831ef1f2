// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>

#include "rig/character.h"

namespace thew::rig {

// Which bodies of other people's skeletons are which bones, by the names that their tools give.

enum class BoneKind {
  kNone,
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kClavicle,
  kHumerus,
  kForearm,
  kHand,
  kThigh,
  kShin,
  kFoot,
  kToes
};
struct BoneName {
  BoneKind kind = BoneKind::kNone;
  int side = 0;  ///< 1 left, -1 right, 0 neither
};

/// "mixamorig:LeftForeArm", "Bip01 R UpperArm", "DEF-upper_arm.L.001", "rShldrBend"; twist bones,
/// fingers, targets and what FBX's reader puts between bodies are none.
BoneName read_bone_name(const std::string& name);
/// Whether FBX's reader put it between two bodies ("Arm_$AssimpFbx$_PreRotation").
bool is_pivot(const std::string& name);

/// Kind and side to body, for what is known: by VRM's map where the file has one, by names, and the
/// trunk by where the limbs hang.
using HumanBodies = std::map<std::pair<BoneKind, int>, int>;
HumanBodies human_bodies(const Character& character);

/// Arms and legs of which names tell nothing, by the skeleton's shape alone, and the trunk with
/// them: pairs of limbs alike, whose longest two bones that meet are the limb; the legs hang above
/// the arms in the tree, and toes tell left from right. What was taken for what, "" for nothing.
std::string add_limbs_by_shape(const Character& character, HumanBodies& bodies);

/// Whether a body is the ancestor or below it.
bool hangs_on(const Skeleton& skeleton, int body, int ancestor);

}  // namespace thew::rig
