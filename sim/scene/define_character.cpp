// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/define_character.h"

#include "rig/import/character_import.h"
#include "rig/import/mesh_import.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::sim {
namespace {

int body_of(const Skeleton& skeleton, const std::string& name, const Location& location) {
  const int body = find_body(skeleton, name);
  if (body >= 0) return body;
  throw Error(ErrorCode::kUsage, location + ": body \"" + name + "\" is not in the character" +
                                     did_you_mean(name, skeleton.body_names) +
                                     "; correct the name");
}

void add_hinge(const SceneHinge& hinge, Skeleton& skeleton) {
  const int body = body_of(skeleton, hinge.body, hinge.location);
  skeleton.joint_names[body] = hinge.name;
  skeleton.joint_types[body] = Skeleton::JointType::kRevolute;
  const Mat3 roll = rotation_about(hinge.along, hinge.roll);
  skeleton.joint_axes[body] = roll.transpose() * hinge.axis;
  skeleton.lower[body] = hinge.range[0];
  skeleton.upper[body] = hinge.range[1];
  skeleton.joint_in_parent[body].linear() *= rotation_about(hinge.axis, -hinge.at_bind) * roll;
}

// Adds a body that has at rest the pose of another.
int add_body(const std::string& name, int like, const Location& location, Skeleton& skeleton) {
  if (find_body(skeleton, name) >= 0) {
    throw Error(ErrorCode::kUsage,
                location + ": there is a body \"" + name + "\" already; give another name");
  }
  skeleton.body_names.push_back(name);
  skeleton.parent.push_back(skeleton.parent[like]);
  skeleton.joint_in_parent.push_back(skeleton.joint_in_parent[like]);
  skeleton.joint_names.emplace_back();
  skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
  skeleton.joint_axes.push_back(skeleton.joint_axes[like]);
  skeleton.lower.push_back(0.0);
  skeleton.upper.push_back(0.0);
  skeleton.visuals.emplace_back();
  return skeleton.size() - 1;
}

Forearm add_forearm(const SceneHinge& hinge, Skeleton& skeleton) {
  const SceneForearm& of = *hinge.forearm;
  const int body = find_body(skeleton, hinge.body);
  if (skeleton.parent[body] < 0) {
    throw Error(ErrorCode::kUsage, hinge.location + ": body \"" + hinge.body +
                                       "\" hangs on none, and so is no forearm; remove forearm");
  }
  const int ulna = add_body(of.ulna, body, hinge.location, skeleton);
  return {body, ulna, add_body(of.radius, body, hinge.location, skeleton), of.head, of.wrist};
}

Scapula add_scapula(const SceneHinge& hinge, Skeleton& skeleton) {
  const SceneScapula& of = *hinge.scapula;
  const int humerus = find_body(skeleton, hinge.body);
  const int on = body_of(skeleton, of.on, hinge.location);
  return {add_body(of.body, on, hinge.location, skeleton),
          on,
          humerus,
          of.axis,
          of.hanging,
          of.from,
          of.share,
          Transform::Identity()};
}

BodyClip named_animation(const Scene& scene, const std::filesystem::path& file,
                         const Character& character) {
  std::vector<std::string> names;
  for (const BodyClip& clip : character.animations) {
    if (clip.name == scene.character.animation) return clip;
    names.push_back(clip.name);
  }
  throw Error(ErrorCode::kUsage, scene.clip_location + ": animation \"" +
                                     scene.character.animation + "\" is not in " + file.string() +
                                     did_you_mean(scene.character.animation, names) +
                                     "; it has: " + (names.empty() ? "none" : names_text(names)));
}

BodyClip motion_of(const Scene& scene, const Character& character,
                   std::vector<std::string>& warnings) {
  const Character motion = import_motion(scene.character.motion);
  if (motion.animations.empty()) {
    throw Error(ErrorCode::kInput,
                scene.character.motion.string() + ": holds no motion; export it with its frames");
  }
  const bool named = !scene.character.animation.empty();
  return retarget(
      motion, named ? named_animation(scene, scene.character.motion, motion) : motion.animations[0],
      character, scene.character.motion_names, scene.clip_location, warnings);
}

}  // namespace

CharacterRig define_character(const Scene& scene, Skeleton& skeleton,
                              std::vector<std::string>& warnings) {
  CharacterRig rig;
  rig.file = scene.rig.lexically_proximate(scene.file.parent_path()).generic_string();
  rig.scale = scene.character.scale;
  rig.character = import_character(scene.rig, scene.character.scale);
  const Character& character = rig.character;
  warnings.insert(warnings.end(), character.warnings.begin(), character.warnings.end());
  if (!character.size_doubt.empty()) warnings.push_back(character.size_doubt);
  skeleton = character.skeleton;
  for (const SceneHinge& hinge : scene.character.hinges) add_hinge(hinge, skeleton);
  if (!scene.character.motion.empty()) {
    rig.clip = motion_of(scene, character, warnings);
  } else if (!scene.character.animation.empty()) {
    rig.clip = named_animation(scene, scene.rig, character);
  }
  rig.skin_pose.assign(skeleton.size(), 0.0);
  for (const SceneHinge& hinge : scene.character.hinges) {
    if (hinge.scapula) rig.skin_pose[find_body(skeleton, hinge.body)] = hinge.at_bind;
    if (hinge.forearm) rig.forearms.push_back(add_forearm(hinge, skeleton));
    if (hinge.scapula) rig.scapulae.push_back(add_scapula(hinge, skeleton));
  }
  rig.skin_pose.resize(skeleton.size(), 0.0);
  Pose rest;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), rest);
  for (Scapula& scapula : rig.scapulae) {
    scapula.at_rest = rest[scapula.on].inverse() * rest[scapula.humerus];
  }
  for (int b = 0; b < character.skeleton.size(); ++b) {
    rig.stretch.push_back(rigid_part(character.bind[b]).inverse() * character.bind[b]);
    rig.rest.push_back(rest[b] * rig.stretch[b]);
  }
  return rig;
}

std::vector<Bone> character_bones(const Scene& scene, const Skeleton& skeleton) {
  std::vector<Bone> bones;
  for (const SceneBone& bone : scene.character.bones) {
    bones.push_back(
        {bone.name, body_of(skeleton, bone.body, bone.location), import_bone(bone.mesh)});
  }
  return bones;
}

}  // namespace thew::sim
