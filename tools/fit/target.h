// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "sim/scene/scene.h"
#include "tools/fit/limb.h"

namespace thew::tools {

/// The arm of assets/arm.
struct Template {
  Scene scene;
  Skeleton skeleton;
  Pose rest;
  std::vector<TriMesh> muscles;  // as those of the scene
  std::vector<TriMesh> bones;    // by body; at rest, in the world
  Vec3 humerus;                  // its origin at rest
  ArmTemplate arm;
};

/// One arm of the character with all that is needed to put the template's things on it.
struct Target {
  const Template& from;
  const Character& character;
  const Pose &straight, &rest;  // in which it is measured; in which its muscles are made
  const Limb &limb, &body;      // the skin around it, measured; all of it
  const TriMesh& hand;          // that of the hand
  ArmBodies arm;
  ArmFit fit;
  std::string side;  // "right" or "left"

  int body_of(int template_body) const {
    const std::string& name = from.skeleton.body_names[template_body];
    if (name == "scapula") return arm.scapula;
    if (name == "humerus") return arm.humerus;
    if (name == "ulna") return arm.ulna;
    return name == "radius" ? arm.radius : arm.hand;
  }
  std::string name_of(int body) const {
    const std::vector<std::string>& names = character.skeleton.body_names;
    if (body == arm.scapula) return names[arm.humerus] + ".scapula";
    if (body == arm.ulna) return names[arm.forearm] + ".ulna";
    return body == arm.radius ? names[arm.forearm] + ".radius" : names[body];
  }
  // Where the template's point goes in the straight pose, and in the rest pose.
  Vec3 measured(const Vec3& world) const { return map_point(fit, world - from.humerus); }
  Vec3 mapped(const Vec3& world) const { return fit.hang * measured(world); }
  // Of what is mapped, moves what lies beyond the wrist as the hand's bones are; empty: it has
  // none.
  std::function<Vec3(const Vec3&)> in_hand = {};
  Vec3 placed(const Vec3& world) const {
    const Vec3 p = mapped(world);
    return in_hand ? in_hand(p) : p;
  }
};

std::string quoted(const std::string& text);
/// The lines `path = ...` and `wrap = ...` of a muscle in a scene; nothing without wraps.
std::string points_text(const std::vector<PathPoint>& points,
                        const std::function<std::string(int body)>& name_of);
std::string wraps_text(const std::vector<WrapCylinder>& wraps,
                       const std::function<std::string(int body)>& name_of);
/// The value of `weights` in a scene, of keys (u, weight): a preset's name where they are its own.
std::string weights_text(const std::vector<std::array<double, 2>>& keys);
TriMesh mapped_mesh(const Target& to, TriMesh mesh);

/// Of a tube (muscles/tube.h): its nodes from `first` on.
struct Ring {
  int first, nodes;
};
std::vector<Ring> rings_of(const TriMesh& tube);
TriMesh mapped_muscle(const Target& to, const TriMesh& mesh);

struct MappedSize {
  double volume, volume_ratio;  // m^3
  double fat;                   // m, least over the muscle; negative: it stands out of the skin
};

/// A file beside the scene.
struct NewFile {
  std::filesystem::path file;
  std::string heading;
  TriMesh mesh;
};

/// What is written of the arms, but for the character itself.
struct NewArms {
  std::vector<NewFile> files;
  std::string rig, muscles, keys;
  std::string fingers;                    ///< their bones, as `rig` has the others
  std::string hands;                      ///< names of their bones, quoted, with commas between
  std::vector<std::string> outside;       ///< muscles that stand out of the skin
  std::vector<std::string> threads;       ///< muscles too thin to be any, with why
  std::vector<std::string> handless;      ///< sides on which no hand's bones have room
  double fat = 1.0;                       ///< m, the least over the muscles
  std::vector<double> lengths;            ///< of the arms, over the template's
  double volume = 0.0, own_volume = 0.0;  ///< m^3, of the muscles and of the template's
  /// Least share of the room under an arm's skin that its muscles take, over the template's.
  double fill = 1e3;
  double in_proportion = 0.0;  ///< m^3, of the muscles in arms as long as the template's
  double thickness = 1e3;      ///< of the thinnest segment, over the template's
  double section = 1e3;        ///< of the thinnest section of a muscle, over the template's
  bool slender = false;        ///< whether any is, for its length

  /// For [scene] size: their length over the template's, in the mean.
  double size() const;
};
/// Whether muscles that take the least share of the room under the skin are more than a strong
/// man's, so that there is fat, or a thick sleeve.
bool is_too_thick(const ArmFit& fit);
/// An arm thicker than the template's of its length has more fat, and no more muscle, as long as
/// the muscles take a fair share of the room under its skin; no more than that if it is hard. Thins
/// all that is mapped so far.
void leave_fat(bool is_hard, Target& to);
void add_arm(Target& to, NewArms& arms);
std::string scene_text(const std::string& name, const std::filesystem::path& character_file,
                       double scale, const Character& character, const ContactSettings& contact,
                       const NewArms& arms, const std::string& views);

/// m, of a muscle's mesh, below which it is a thread.
double least_edge(const ArmFit& fit);
/// Why no muscles can be put on the arm; "" if they can.
std::string why_no_arm(const ArmFit& fit, const std::string& side);
/// Why a muscle of it is none, in the words after its name; "" if it is one.
std::string why_thread(const Target& to, const TriMesh& muscle, const MappedSize& size);
/// The arm from before and from its side: its skin, its bones, what was measured and what is usual.
/// SVG.
std::string why_picture(const ArmTemplate& from, const ArmFit& fit, const TriMesh& skin,
                        const std::string& title);

/// Over the template's, of the upper arm and of the forearm.
std::array<double, 2> thickness_of(const Target& to);
/// Moves the hand's bones, mapped as the forearm's, into the character's hand. Returns
/// Target::in_hand; empty where there is no room for them.
std::function<Vec3(const Vec3&)> fit_hand(const Target& to, TriMesh& bones);

/// One of the hand's bones: `mesh` is mapped as the forearm's, in the rest pose.
struct HandBone {
  int of_template;            ///< its body there
  TriMesh mesh;               ///< m
  int body = -1;              ///< of the character, on which it hangs
  Vec3 joint = Vec3::Zero();  ///< m, where it begins; filled by fit_fingers
};
/// As fit_hand, for a character with fingers of its own, of which each gets its own bones: a thumb
/// and two to four others. What it has no finger for is dropped. Empty, and `bones` as they were,
/// where its bodies tell no such fingers or there is no room in them.
std::function<Vec3(const Vec3&)> fit_fingers(const Target& to, std::vector<HandBone>& bones);
/// Adds the triangles of a mesh to another.
void append_mesh(const TriMesh& mesh, TriMesh& to);

/// The scene's table of a template's muscle; `mesh` is its file in the scene's folder.
std::string muscle_text(const Target& to, const SceneMuscle& muscle, const std::string& name,
                        const std::filesystem::path& mesh, const MappedSize& size);

}  // namespace thew::tools
