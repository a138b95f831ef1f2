// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "muscles/muscle.h"
#include "rig/character.h"
#include "rig/character_limbs.h"
#include "rig/clip.h"
#include "rig/mesh_motion.h"
#include "skin/contact/contact.h"
#include "skin/skin_layer.h"

namespace thew::sim {

/// Time, gravity and size, which a scene, its definition and its model all have.
struct World {
  std::string name = "scene";
  double fps = 24.0;
  int first_frame = 1, last_frame = 1;
  double settle = 2.0;  ///< s, the longest time before the first frame
  Vec3 gravity = Vec3(0, -9.81, 0);
  /// This body's length over that of a grown man: it multiplies every length that is not given.
  double size = 1.0;
};

enum class Integrator { kExplicit, kXpbd, kLocalGlobal, kQuasiStatic };
/// The words for them in a scene, in the order of the enum.
inline constexpr const char* kIntegrators[] = {"explicit", "xpbd", "local_global", "quasi_static"};

/// How the multiplier that holds the volume is found.
enum class VolumeMethod {
  kNone,
  kPrinted,
  kLinear,
  kPenalty,     ///< a bulk stiffness stands for it: a yardstick
  kExact,       ///< explicit: linear in each substep, exact at the frame's end
  kExactAlways  ///< explicit: exact in each substep
};
inline constexpr const char* kVolumeMethods[] = {"none",    "printed", "linear",
                                                 "penalty", "exact",   "exact_always"};

struct Tolerance {
  double position = 0.0;  ///< m, the error of any node in any frame against the refined step
  double volume = 1e-9;   ///< relative error; that of the exact multiplier is far below
  std::string location = {};
};

struct SolverSettings {
  Integrator integrator = Integrator::kLocalGlobal;
  VolumeMethod volume = VolumeMethod::kExact;
  int substeps = 1;  ///< a frame; explicit: each in as many as its stability asks for
  int iterations = 3;
  bool rungs = true;  ///< see rungs.h; false: a step that cannot be solved throws StepFailure
  /// In place of integrator, substeps and iterations: fidelity/planner.h chooses for each muscle.
  std::optional<Tolerance> tolerance;
};

struct ContactOptions {
  bool enabled = true;
  ContactSettings settings;
  double friction = 0.0;                                  ///< coefficient, of all surfaces
  std::vector<std::pair<std::string, double>> thickness;  ///< m, by the name of a muscle or bone
};
/// Besides: the pairs of muscles or bones that do not meet, and the muscles that meet themselves.
struct ContactDef : ContactOptions {
  std::vector<std::pair<std::string, std::string>> ignore;
  std::vector<std::string> self;
  std::vector<std::pair<std::string, std::vector<double>>> thicknesses;  ///< m, by name, by node
};

/// A mesh that is fixed to a body, and that muscles meet.
struct Bone {
  std::string name;
  int body = -1;
  TriMesh in_body;  ///< m, closed and outward
  /// Set: the mesh and its body, which no other mesh has, move by this and by no joint.
  std::shared_ptr<const MeshMotion> motion = {};
  bool prop = false;  ///< is no part of the character: it presses on its skin from outside

  bool bends() const { return motion && !motion->shapes.empty(); }
};

/// A rig that is a character's file. Its muscles are made in the rest pose, which is the bind pose
/// with all hinges at 0.
struct CharacterRig {
  std::string file;    ///< of the character, relative to the scene's folder
  double scale = 1.0;  ///< that multiplied all its lengths
  Character character;
  BodyClip clip;             ///< empty: keys drive the hinges
  std::vector<Affine> rest;  ///< world transforms in the rest pose, stretch included
  std::vector<Affine>
      stretch;  ///< by body: the stretch of the bind pose, which its rigid frame leaves out
  std::vector<Forearm>
      forearms;  ///< their bones are bodies of the model's skeleton alone, its last
  std::vector<Scapula> scapulae;  ///< likewise
  /// rad, by body, the hinges' angles where the skin is tied to the muscles: shoulders as in the
  /// bind pose, all others 0.
  std::vector<double> skin_pose;
};

struct SkinDef {
  TriMesh mesh;                          ///< of a layer; empty: none
  bool skinned = false;                  ///< the character's own mesh by its own weights; no `mesh`
  std::vector<std::string> ignore = {};  ///< bones that it does not feel
  /// Set: the shape of a layer where nothing presses on it, in place of one that the bodies carry.
  std::shared_ptr<const MeshMotion> motion = {};
  SkinSettings settings;
  SkinMaps maps = {};
  std::string location = {};  ///< its file, for messages
};

/// All that a model is built of, in memory: nothing here is read from a file.
struct ModelDef : World {
  std::string source = "scene";  ///< its file, for messages
  Skeleton skeleton;
  Clip clip;                       ///< time 0 at the first frame; without keys all joints stay at 0
  std::string clip_location = {};  ///< begins messages about it
  std::optional<CharacterRig> character;
  std::vector<MuscleDef> muscles;
  std::vector<Bone> bones;  ///< props last
  SkinDef skin;
  SolverSettings solver;
  ContactDef contact;
  std::vector<std::string> warnings;
};

}  // namespace thew::sim
