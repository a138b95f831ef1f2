// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/author/bones.h"

namespace thew::tools {

/// A finger at rest, relaxed, in the humerus' frame. Points: base of its metacarpal, its joints,
/// its tip; the thumb has one joint less. Measured on BodyParts3D.
struct Finger {
  std::string name;
  std::vector<Vec3> points;   ///< m
  std::vector<double> flesh;  ///< m, radius at the points
  double bone = 1.0;          ///< its bones' thickness by that of the middle finger's
  Vec3 bends_to;              ///< unit vector, where it goes when it flexes
};
const std::array<Finger, 5>& fingers();

/// A bone of a finger that moves by itself, and the joint at its near end.
struct FingerBone {
  std::string body, joint;
  int finger = 0, part = 0;         ///< from points[part] to points[part + 1]
  Vec3 axis;                        ///< unit vector, flexion positive
  double lower = 0.0, upper = 0.0;  ///< degrees
};
/// The nearest to the hand first, of these from the thumb's to the little finger's.
std::vector<FingerBone> finger_bones();

/// The hand without them: carpus and four metacarpals.
BoneShape hand_bone();
BoneShape shape_of(const FingerBone& bone);

/// Level of the hand's skin: palm, balls of thumb and little finger, fingers. Strokes of one finger
/// melt into each other, into the palm and, between them, into those of the next finger.
double hand_level(const Vec3& p);

}  // namespace thew::tools
