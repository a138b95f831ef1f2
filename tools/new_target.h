// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene.h"
#include "tools/new_arm.h"

namespace thew {

/// The arm of assets/arm.
struct Template {
  Scene scene;
  Skeleton skeleton;
  Pose rest;
  Vec3 humerus;  // its origin at rest
  ArmTemplate arm;
};

/// One arm of the character with all that is needed to put the template's things on it.
struct Target {
  const Template& from;
  const Character& character;
  const Pose& rest;
  const TriMesh& skin;  // at rest
  ArmBodies arm;
  ArmFit fit;
  std::string side;  // "right" or "left"

  int body_of(int template_body) const {
    const std::string& name = from.skeleton.body_names[template_body];
    if (name == "scapula") return arm.clavicle;
    if (name == "humerus") return arm.humerus;
    if (name == "ulna") return arm.ulna;
    return name == "hand" ? arm.hand : arm.radius;
  }
  std::string name_of(int body) const {
    const std::vector<std::string>& names = character.skeleton.body_names;
    if (body == arm.ulna) return names[arm.forearm] + ".ulna";
    return body == arm.radius ? names[arm.forearm] + ".radius" : names[body];
  }
  Vec3 mapped(const Vec3& world) const { return map_point(fit, world - from.humerus); }
};

std::string quoted(const std::string& text);
TriMesh mapped_mesh(const Target& to, TriMesh mesh, const Transform& into);

struct MappedSize {
  double volume, volume_ratio;  // m^3
  double fat;                   // m, least over the muscle; negative: it stands out of the skin
};

/// The scene's table of a template's muscle; `mesh` is its file in the scene's folder.
std::string muscle_text(const Target& to, const SceneMuscle& muscle, const std::string& name,
                        const std::filesystem::path& mesh, const MappedSize& size);

}  // namespace thew
