// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>

#include "rig/character.h"

namespace thew::rig {

// Tells which body of a skeleton is which bone of a person, by the names that common tools give to
// bones and by the geometry of the skeleton.

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

/// The bone and side that a name stands for: "mixamorig:LeftForeArm", "Bip01 R UpperArm",
/// "DEF-upper_arm.L.001", "rShldrBend", "右ひじ". kNone for twist bones, fingers, targets and the
/// helper bodies of is_pivot().
BoneName read_bone_name(const std::string& name);
/// The side of a limb of these bodies (-1: none there), of which the other is the counterpart, by
/// their names: 1 left, -1 right; 0 where they do not tell.
int side_by_names(const Skeleton& skeleton, const std::vector<int>& limb,
                  const std::vector<int>& other);
/// Whether it is a helper that assimp inserts between two bodies of an FBX file
/// ("Arm_$AssimpFbx$_PreRotation").
bool is_pivot(const std::string& name);

/// The body of each bone that is known. Sources, in this order: the VRM map of the file, the names
/// of the bodies, and for the trunk the bodies to which both arms or both legs are attached.
using HumanBodies = std::map<std::pair<BoneKind, int>, int>;
HumanBodies human_bodies(const Character& character);

/// Adds chest, hips and spine: the common ancestors of both arms and of arms and legs.
void add_trunk(const Skeleton& skeleton, HumanBodies& bodies);
/// Adds arms or legs that no name tells, by the geometry of the skeleton, and the trunk with them.
/// A limb is two long bones of a chain, each of one body or of several in a line, the first a
/// little longer than the second; limbs come in pairs of nearly equal length. Legs are attached
/// nearer to the root than arms. Names tell left from right, or else the toes. Without legs the
/// longest pair has the arms. Returns which bodies were taken for which bones, "" if none was
/// added.
std::string add_limbs_by_geometry(const Character& character, HumanBodies& bodies);

/// Of an upper arm's length, what a person's shoulders are farther apart than.
inline constexpr double kShouldersApart = 0.5;
/// A person's upper arm over the forearm, in length.
inline constexpr double kUpperOverFore = 1.2;

/// Whether an upper arm that reaches to the body `end` begins beside the trunk: one that begins
/// where the other side's of the same depth in the tree does ("ToArm") is none.
bool begins_beside(const Character& character, int humerus, int end);

/// `humerus`, or of the bodies above the forearm with an upper arm's name on its side the one of a
/// person's length; or the body above it where that is the first part of an upper arm in two: names
/// call it a shoulder, as they do the body it hangs on, and an upper arm that is shorter than the
/// forearm runs on straight from it (MakeHuman's shoulder02).
int whole_humerus(const Character& character, int humerus, int forearm, int hand);

/// m, of a body's origin in the bind pose.
inline Vec3 position_of(const Character& character, int body) {
  return character.bind[body].translation();
}

/// Whether `body` is `ancestor` or a descendant of it.
bool hangs_on(const Skeleton& skeleton, int body, int ancestor);

}  // namespace thew::rig
