// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "muscles/path.h"
#include "rig/character.h"
#include "rig/character_bones.h"

namespace thew::tools {

class Limb;

/// Bodies of a character's arm; where there is no clavicle, the body that the upper arm hangs on.
struct ArmBodies {
  bool left = false;
  int clavicle = -1, humerus = -1, forearm = -1;
  int hand = -1;              ///< the forearm where that carries the hand, or there is none
  Vec3 wrist = Vec3::Zero();  ///< m, in the frame of `hand`
  /// Bodies that the scene adds, in the rest pose after the character's own.
  int ulna = -1, radius = -1, scapula = -1;

  bool has_hand() const { return hand != forearm; }
  Vec3 wrist_in(const Pose& pose) const { return pose[hand] * wrist; }
};

/// What the user said: "humerus" or "left_humerus" -> name of a body.
using BoneMap = std::map<std::string, std::string>;

/// The arms asked for ("left", "right", "both"), by the map, by names, or by the shape of the
/// skeleton: two chains alike on either side of the upper body. Throws Error(kUsage) with the
/// candidates where that leaves doubt; what was guessed from the shape is said in `notes`.
std::vector<ArmBodies> find_arms(const Character& character, const std::string& side,
                                 const BoneMap& map, const std::string& place,
                                 std::vector<std::string>& notes);

/// Share of the skin around the forearm and beyond the wrist, by area, that hangs on bodies which
/// the arm does not carry, such as goals of inverse kinematics on the trunk; sets the one with the
/// most of it, if there is any.
double skin_left_behind(const Character& character, const ArmBodies& arm, int& most);

/// Unit and horizontal, at right angles to the line of the shoulders: where the feet point to, seen
/// from the ankles; zero where the character has no feet.
Vec3 facing_of(const Character& character, const Vec3& shoulders);

/// How thick the character's arm is over the template's: by section (the template's y) and by
/// direction around the bone, between nodes bilinear, held beyond the first and last section.
struct GirthField {
  struct Share {
    int node;
    double share;
  };
  static constexpr double kRow = 0.01;  ///< m of the template, from section to section
  static constexpr int kAround = 24;    ///< directions
  double even = 1.0;                    ///< everywhere, where no ratios are known
  double top = 0.0;                     ///< m, y of the first section
  int rows = 0;
  std::vector<double> ratio;  ///< by section, then by direction
  /// m, from the axis to the template's skin; to the character's, while across is as in the
  /// template.
  std::vector<double> own, skin;
  std::vector<Vec3> shift;  ///< m, of the axis in the character, by section
  /// Upper arm, forearm: share of the sections that the skin tells of; the skin's mean distance
  /// over what is usual for the segment's length.
  std::array<double, 2> told{}, thick{};

  double& at(int row, int direction);
  std::array<Share, 4> shares(double y, double angle) const;
  double value(double y, double angle) const;
  double skin_at(double y, double angle) const;
  Vec3 shift_at(double y) const;
  double mean(double from, double to) const;  ///< over the sections from y down to y
};

/// The template in its humerus frame (x forward, y up the shaft, z outward) at rest.
struct ArmTemplate {
  Vec3 elbow, wrist, elbow_axis;
  TriMesh skin;             ///< closed
  std::vector<Vec3> flesh;  ///< what has to stay under the skin
};

/// From the first section to the wrist.
struct ArmSize {
  double upper_girth = 0.0, fore_girth = 0.0;  ///< m, the largest; above, of the upper arm's middle
  double room = 0.0;                           ///< m^3, under the skin
};

/// The template's humerus frame onto the character's arm in the rest pose: along each segment
/// stretched by its length, across by the girth of the skin, and smoothly from one segment to the
/// other in the elbow.
struct ArmFit {
  Vec3 elbow_template, wrist_template, elbow;  ///< m
  Mat3 upper, fore;    ///< about the elbow; `across` at right angles to the bones
  double blend = 0.0;  ///< m in the template, half of the elbow's
  bool mirrored = false;
  GirthField girth;
  ArmSize size, own_size;  ///< of the character, of the template

  Vec3 hinge_axis;       ///< unit, world, rest pose
  double at_bind = 0.0;  ///< rad
  Vec3 along;            ///< unit, world, bind pose: from elbow to wrist
  double roll = 0.0;     ///< rad about it, from the bind pose to the rest pose
  /// Animations that roll the forearm farther from the rest pose than an arm's turns.
  std::vector<std::string> wringing;
  Mat3 frame;      ///< turn (or turn and mirror) of the upper arm
  Transform hang;  ///< m, of the arm as it is bound, to where it hangs as the template's
  Vec3 upwards;    ///< unit, world: about which the scapula turns as the arm rises
  double along_upper, along_fore;  ///< over the template's
  double across = 1.0;             ///< of both segments together, over the template's
};

/// All but the girth, which the skin in the pose of straight elbows tells.
ArmFit fit_arm(const Character& character, const ArmBodies& arm, const ArmTemplate& from);
/// Where `limb` tells nothing the girth stays empty; `body` is all the skin. Else `from.flesh` lies
/// under it afterwards, with a little fat left, wherever the arm's axis does.
void fit_girth(const ArmTemplate& from, const Limb& limb, const Limb& body, ArmFit& fit);
Vec3 map_point(const ArmFit& fit, const Vec3& p);
/// The template's arm's axis at its section y, and what maps offsets from there but for the girth.
Vec3 axis_point(const ArmFit& fit, double y);
Mat3 linear_at(const ArmFit& fit, double y);
/// m, from where the template's points go to the skin, away from the axis, the least; negative
/// outside.
double least_fat(const ArmFit& fit, const Limb& limb, const Limb& body,
                 const std::vector<Vec3>& points);

/// Girth over length, of the template's, below which an arm is slender.
inline constexpr double kSlender = 0.75;

/// What crosses the elbow in one piece would, in a fold, stand out of an arm more slender than the
/// template's: its ends lie as far from the joint as the bones are long. A place on the piece on
/// either side, as far from the joint as the girth asks for, holds it to the humerus and the ulna
/// (the radius rolls); the straight arm is the same. `heights` are the template's y of the path's
/// points.
void hold_at_elbow(const ArmFit& fit, const ArmBodies& arm, const Pose& rest,
                   const std::vector<double>& heights, MusclePath& path);

/// Paths from the shoulder blade to the humerus, for arms that are raised. What a path has on the
/// blade below the joint, the origin apart, goes with the humerus instead, by a share of its turn
/// against the blade. Points on the humerus' head share the turn among them, as a tendon slides
/// over the head. A path that leaves the blade beside the joint for a place far down the humerus
/// gets a point between that takes a share as well, so that it goes round the head. The path at
/// rest is the same.
void hold_at_shoulder(const ArmBodies& arm, const Pose& rest, MusclePath& path);

/// The pose in which the arm is measured: the bind pose with the elbow straight as the template's,
/// and the forearm rolled as its animations have it.
Pose straight_pose(const Character& character, const std::vector<ArmBodies>& arms,
                   const std::vector<ArmFit>& fits);
/// The rest pose, in which muscles are made: that one with the arms hanging as the template's does,
/// so that muscles lie to the shoulder blade as its do. Poses have the bodies of ArmBodies as well.
Pose hanging_pose(const Character& character, const Pose& straight,
                  const std::vector<ArmBodies>& arms, const std::vector<ArmFit>& fits);

/// The scene's views of the arms, whichever poses they take.
std::string views_text(const Character& character, const std::vector<ArmBodies>& arms,
                       const std::vector<ArmFit>& fits);

/// The character's skin in any pose.
Points skin_in_pose(const Character& character, const Pose& pose);

}  // namespace thew::tools
