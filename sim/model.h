// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "muscles/carried_shape.h"
#include "muscles/ring_springs.h"
#include "muscles/skyline.h"
#include "muscles/springs.h"
#include "muscles/volume_zones.h"
#include "rig/character.h"
#include "sim/fidelity.h"
#include "sim/scene.h"
#include "skin/face_contact.h"
#include "skin/skin_layer.h"
#include "skin/skinned_skin.h"

namespace thew {

/// One muscle: what does not change during a bake.
struct Muscle {
  std::string name;
  TriMesh rest;
  FileOrder order;  ///< in which a bake has it
  Surface surface;
  double rest_volume = 0.0;  ///< m^3
  VolumeZones zones;         ///< empty: one multiplier for all of it
  CarriedShape shape;
  Springs springs;
  RingSprings rings;                       ///< the same by node
  std::vector<double> mass;                ///< kg
  double highest_frequency_squared = 0.0;  ///< 1/s^2, of the springs at rest
  std::vector<char> driven, free_nodes;
  std::vector<SurfacePoint> held_points;  ///< that contact keeps out of faces
  double thickness = 0.0;                 ///< m, that contact keeps free over it
  std::vector<int> bodies;                ///< that move it, each once
  std::vector<double> authored_weights;   ///< as the scene has them, by node
  /// Of the multiplier: the authored ones, faded out towards the tendons; sum n, 0 where driven.
  std::vector<double> weights;
  double weight_floor = 0.0;  ///< added to all, where the authored lie on too few nodes
  bool swells = true;         ///< the target shape; else the weights alone
  SceneMuscle settings;
  Skyline stiffness;  ///< sum of spring stiffness over free nodes, N/m
  /// By node, N/m, 0 where driven: of the order by which a patch of nodes gives way together.
  std::vector<double> contact_stiffness;
  /// The springs between a free node and a driven one.
  struct Anchored {
    int node, anchor;
    double stiffness;  ///< N/m
  };
  std::vector<Anchored> anchored;
};

/// A rigid mesh, fixed to a body.
struct Bone {
  std::string name;
  int body = -1;
  TriMesh in_body;
  Surface surface;
  std::vector<SurfacePoint> held_points;  ///< as a muscle's
  double thickness = 0.0;                 ///< m
};

enum class Integrator { kExplicit, kXpbd, kLocalGlobal, kQuasiStatic };
/// Of a scene's word.
Integrator integrator_of(const std::string& word);

/// How the multiplier of the volume is found.
enum class VolumeMethod {
  kNone,
  kPrinted,
  kLinear,
  kPenalty,     ///< a bulk stiffness in its place: a yardstick
  kExact,       ///< explicit: linear in each substep, exact at the frame's end
  kExactAlways  ///< explicit: exact in each substep
};

/// A character's forearm as two bodies, see SceneForearm.
struct Forearm {
  int body, ulna, radius;
  Vec3 head, wrist;  ///< m, in the body's frame
};

/// A rig that is a character's file. Muscles are made in the rest pose: the bind pose with its
/// hinges at 0.
struct CharacterRig {
  Character character;
  BodyClip clip;                ///< empty: the scene's keys drive the hinges
  std::vector<Affine> rest;     ///< world transforms in the rest pose, stretch included
  std::vector<Affine> stretch;  ///< by body, what its frame without stretch lacks
  std::vector<Forearm>
      forearms;  ///< their bones are bodies of the model's skeleton alone, its last
};

struct Model {
  Scene scene;
  Lengths lengths;  ///< of the scene's size
  Skeleton skeleton;
  std::vector<Muscle> muscles;
  std::vector<Bone> bones;
  SkinModel skin;  ///< empty surface: none
  bool has_skin = false;
  std::optional<CharacterRig> character;  ///< where the rig is a character's file
  std::optional<SkinnedSkin> skinned;     ///< stands for `skin` but for its triangles and rest
  Integrator integrator = Integrator::kLocalGlobal;
  VolumeMethod volume = VolumeMethod::kExact;
  /// [muscle][collider], colliders being the muscles and then the bones: pairs left out of contact.
  std::vector<std::vector<char>> ignore;
  /// Where the scene gives a tolerance: what was chosen (fidelity_planner.h).
  std::optional<Fidelity> fidelity;
  std::string hash;  ///< XXH3-128 of all that the solver reads, hex
  /// The same by its parts, "clip" or "muscle \"biceps_long\"", to say which of them differ.
  std::vector<std::pair<std::string, std::string>> part_hashes;
  std::vector<std::string> warnings;

  int colliders() const { return static_cast<int>(muscles.size() + bones.size()); }
};

/// Reads all that the scene names and builds the model. Throws Error with file, cause, next move.
Model build_model(const Scene& scene);

}  // namespace thew
