// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rig/character.h"

namespace thew {

/// Bodies of a character's arm; where there is no clavicle, the body that the upper arm hangs on.
struct ArmBodies {
  bool left = false;
  int clavicle = -1, humerus = -1, forearm = -1, hand = -1;
};

/// What the user said: "humerus" or "left_humerus" -> name of a body.
using BoneMap = std::map<std::string, std::string>;

/// The arms asked for ("left", "right", "both"), by the map, by names, or by the shape of the
/// skeleton: two chains alike on either side of the upper body. Throws Error(kUsage) with the
/// candidates where that leaves doubt; what was guessed from the shape is said in `notes`.
std::vector<ArmBodies> find_arms(const Character& character, const std::string& side,
                                 const BoneMap& map, const std::string& place,
                                 std::vector<std::string>& notes);

/// Unit and horizontal, at right angles to the line of the shoulders: where the feet point to, seen
/// from the ankles; zero where the character has no feet.
Vec3 facing_of(const Character& character, const Vec3& shoulders);

/// The template's humerus frame (x forward, y up the shaft, z outward) onto the character's arm in
/// the rest pose: stretched along each segment by its length, across by the girth of the skin, and
/// smoothly from one to the other in the elbow.
struct ArmFit {
  Vec3 elbow_template, elbow;  ///< m
  Mat3 upper, fore;            ///< linear parts about the elbow
  double blend = 0.0;          ///< m in the template, half of the elbow's
  bool mirrored = false;

  Vec3 hinge_axis;       ///< unit, world, rest pose
  double at_bind = 0.0;  ///< rad
  Mat3 frame;            ///< turn (or turn and mirror) of the upper arm
  double along_upper, along_fore, girth_upper, girth_fore;  ///< over the template's
};
/// Landmarks of the template in its humerus frame.
struct ArmLandmarks {
  Vec3 elbow, wrist, elbow_axis;
  double girth_upper, girth_fore;  ///< m, mean distance of the skin from the axis
};

ArmFit fit_arm(const Character& character, const ArmBodies& arm, const ArmLandmarks& landmarks);
Vec3 map_point(const ArmFit& fit, const Vec3& p);
/// The rest pose: the bind pose with the elbow straight as the template's.
Pose rest_pose_of(const Character& character, const std::vector<ArmBodies>& arms,
                  const std::vector<ArmFit>& fits);

/// m, mean distance from the axis of the points along the middle of a segment; 0: too few.
double girth_of(const std::vector<Vec3>& points, const Vec3& from, const Vec3& to);

}  // namespace thew
