// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/scene/fidelity_levels.h"
#include "sim/scene/model_def.h"
#include "skin/skinned_skin.h"

namespace thew::sim {

/// The surface of a muscle or a bone, as contact meets it.
struct ContactSurface {
  std::string name;
  int body = -1;  ///< the body that carries it; -1: it is a muscle
  Surface surface;
  std::vector<SurfacePoint> rigid_points;  ///< points that contact keeps out of the faces of others
  double thickness = 0.0;                  ///< m, what contact keeps free over it
  std::vector<double> thicknesses;         ///< m, the same by node; empty: alike
};

/// What does not change while a scene is simulated.
struct Model : World {
  std::string source;  ///< its file, for messages
  Lengths lengths;     ///< of the world's size
  Skeleton skeleton;
  Clip clip;
  std::optional<CharacterRig> character;  ///< set where the rig is a character's file
  std::vector<Muscle> muscles;
  std::vector<Bone> bones;
  std::vector<int> cached;  ///< bones with a motion, but for props, parents before their children
  std::vector<ContactSurface> surfaces;  ///< by collider: the muscles, then the bones
  SkinModel skin;                        ///< its surface is empty where there is no skin layer
  std::shared_ptr<const MeshMotion> skin_motion;  ///< see SkinDef
  bool has_skin = false;
  std::optional<SkinnedSkin>
      skinned;  ///< set: it moves in place of `skin`, whose triangles and rest it has
  std::vector<char> skin_bends;  ///< by body: whether its joint bends the skin; empty: each may
  std::vector<char> skin_feels;  ///< by collider: whether the skin is kept out of it
  SolverSettings solver;
  ContactOptions contact;
  /// [muscle][collider]: pairs left out of contact.
  std::vector<std::vector<char>> ignore;
  /// Where there is a tolerance: the level of each muscle, see fidelity/planner.h.
  std::optional<Fidelity> fidelity;
  std::string hash;  ///< XXH3-128 of all that the solver reads, hex
  /// The same of each part, "clip" or "muscle \"biceps_long\"", to say which of them differ.
  std::vector<std::pair<std::string, std::string>> part_hashes;
  std::vector<std::string> warnings;

  int colliders() const { return static_cast<int>(surfaces.size()); }
};
/// Colliders that lie below a skin layer, the first of all: what comes after them are props.
inline int below_skin(const Model& model) {
  int count = model.colliders();
  for (const Bone& bone : model.bones) count -= bone.prop;
  return count;
}

}  // namespace thew::sim
