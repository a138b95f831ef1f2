// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "muscles/weights.h"
#include "sim/maps/node_map.h"
#include "sim/scene/model_def.h"

namespace thew::sim {

/// Where in the scene file something stands: "arm.toml:12".
using Location = std::string;

/// A muscle without a mesh is a tube along its path: two poles and `rings` rings between them, of
/// `around` nodes each. Its radius is given by the share u of the path, 0 to 1.
struct TubeProfile {
  int around = 20, rings = 17;
  std::vector<std::array<double, 2>> radius;  ///< (u, m)
};

struct ScenePathPoint {
  std::string body;
  Vec3 position = Vec3::Zero();
  Location location = {};
  std::string with = {};  ///< another body; empty: the point goes with `body` alone, see PathPoint
  double share = 1.0;
};
struct SceneWrap {
  int segment = 0;
  std::string body;
  Vec3 centre = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0.0, turn = 1.0;
  Location location = {};
};

/// From a mesh file to the rest pose: scaled, then turned, then moved.
struct MeshTransform {
  double scale = 1.0;
  Vec3 axis = Vec3::UnitY();  ///< unit
  double angle = 0.0;         ///< degrees
  Vec3 move = Vec3::Zero();   ///< m
};

/// Nodes of a soft body that a body of the rig holds: those in a box of the rest pose (m).
struct SceneFixed {
  std::string body;
  Vec3 low = Vec3::Constant(-1e12), high = Vec3::Constant(1e12);
  Location location = {};
};

struct SceneMuscle : MuscleSettings {
  enum class Shape { kTarget, kWeights };
  std::string name;
  Location location;
  std::filesystem::path mesh;                                  ///< empty: `profile` is used
  Eigen::Affine3d mesh_to_rest = Eigen::Affine3d::Identity();  ///< see MeshTransform
  TubeProfile profile;
  /// Empty: a soft body, which springs of rest length and its volume alone shape.
  std::vector<ScenePathPoint> path;
  std::vector<SceneWrap> wraps;
  std::vector<SceneFixed> fixed;  ///< of a soft body; the first box that a node lies in counts
  /// m along the rest path, first and last ring of the belly; both 0: not given
  std::array<double, 2> belly = {0.0, 0.0};
  double twist_from = 0.0;  ///< m along the rest path; beyond it the insertion's twist is taken
  NodeMap weights = {.keys = WeightProfile{}.keys};
  NodeMap stiffness;    ///< N/m; where it is not given, material.stiffness everywhere
  bool mirror = false;  ///< the mesh and its maps are those of the other side
  Shape shape = Shape::kTarget;
  Vec3 colour = Vec3(0.62, 0.16, 0.13);
  int zones = 4;  ///< solver.volume = "zonal": each keeps its volume
};

struct SceneView {
  std::string name;           ///< where it is one of the words below, it says what is drawn
  std::string show = "skin";  ///< skin | muscles | weights | cutaway
  Vec3 eye = Vec3(1, 0, 0), target = Vec3::Zero(), up = Vec3::UnitY();
  double field_of_view = 30.0;  ///< degrees, vertical
  Vec3 light = Vec3::Zero();    ///< towards the key light; zero: over the eye's left shoulder
  /// Of a cutaway: planes of unit normal n and distance d (m). The skin is open at those points p
  /// of its rest pose where n . p > d for all of them.
  std::vector<std::array<double, 4>> cut;
  Vec3 from = Vec3::Zero();  ///< unit, towards the eye, which framing.h finds; zero: `eye` is given
  std::string follow;        ///< the body with which eye and target move; empty: they stay
  Location location;
  // Of framing.h:
  int first_frame = 1;
  std::vector<Vec3> moves;    ///< m, of that body from its rest pose, by frame from the first on
  Vec3 moved = Vec3::Zero();  ///< m, the one that eye and target have made, of a single frame
};
/// As many as bound a box; the shader has room for so many.
inline constexpr std::size_t kMostCuts = 6;

struct SceneRender {
  bool has_rig = true;  ///< whether the file has bodies whose motion cameras can go by
  int width = 960, height = 540;
  std::vector<SceneView> views;
};

/// A character's forearm is one body. This gives it the two bones of an arm: the ulna follows the
/// hinge without the body's roll about its length. The radius turns by that roll about the line
/// from its head, which the ulna holds, to the wrist.
struct SceneForearm {
  std::string ulna, radius;                         ///< names of the two new bodies
  Vec3 head = Vec3::Zero(), wrist = Vec3::UnitY();  ///< m, in the body's frame
};
/// A character's shoulder blade, as a body of its own: it lies on the body `on` and turns about the
/// shoulder joint as the arm is raised (scapulohumeral rhythm, Inman et al. 1944).
struct SceneScapula {
  std::string body, on;           ///< names of the new body, and of the one that carries it
  Vec3 axis = Vec3::UnitX();      ///< unit, in the frame of `on`: about which it turns upwards
  Vec3 hanging = -Vec3::UnitY();  ///< unit, in the frame of `on`: where a hanging arm points
  double from = 30.0 * kDegree;   ///< rad, elevation of the arm from which on it turns
  double share = 1.0 / 3.0;       ///< of the elevation beyond that
};
/// A joint that turns a body of a character about one axis, so that keys can drive it.
struct SceneHinge {
  std::string name, body;
  Vec3 axis = Vec3::UnitX();   ///< unit, in the body's frame
  double at_bind = 0.0;        ///< rad, its angle in the bind pose; muscles are made where it is 0
  Vec3 along = Vec3::UnitY();  ///< unit, in the body's frame: along its length
  double roll =
      0.0;  ///< rad about `along`, from the bind pose to the pose in which the muscles are made
  std::array<double, 2> range = {-3.2, 3.2};  ///< rad
  std::optional<SceneForearm> forearm;
  std::optional<SceneScapula> scapula;
  Location location;
};
struct SceneBone {
  std::string name, body;
  std::filesystem::path mesh;   ///< in the body's frame
  std::filesystem::path cache;  ///< of a cached rig, which has no `body`
  Location location;
};
/// What [rig] says besides where its bones come from a cache.
struct SceneCachedRig {
  bool given = false;
  double scale = 1.0;
  std::optional<double> start;  ///< frame of the scene at the first sample; none: the first
  /// Frame of the scene in which the muscles were made. None: the first sample of a bake; of other
  /// caches the meshes as they are.
  std::optional<double> bind;
};
/// A mesh that is no part of the character, and that muscles meet as they meet bones.
struct SceneCollider {
  std::string name, part;
  std::filesystem::path mesh, cache;  ///< a bake, or a point cache of the mesh; empty: it stays
  double scale = 1.0;
  std::optional<double> start;
  Location location;
};
/// What [rig] says besides where its file is a character.
struct SceneCharacter {
  bool given = false;
  double scale = 1.0;
  std::string animation;         ///< its name; empty: the clip's keys, or the first of `motion`
  std::filesystem::path motion;  ///< a BVH, or another character's file
  std::vector<std::array<std::string, 2>>
      motion_names;  ///< name of a body in `motion`, and in the character
  std::vector<SceneHinge> hinges;
  std::vector<SceneBone> bones;
};

struct SceneSkin {
  std::filesystem::path mesh;       ///< empty: no skin
  bool skinned = false;             ///< the character's own mesh by its own weights; no `mesh`
  bool enabled = true;              ///< false: it is read and checked, and then left out
  std::vector<std::string> ignore;  ///< bones that it does not feel
  std::filesystem::path
      cache;  ///< animates `mesh`, or is a bake that has it; empty: bones carry it
  std::optional<double> start;
  SkinSettings settings;
  /// m, of the rest shape over the flesh; negative, and no map: as the mesh was modelled.
  double fat = -1.0;
  NodeMap fat_map;
  double slide = 1.0;  ///< 0..1
  NodeMap slide_map;
  Location location;
};

struct SceneSolver {
  /// In place of integrator, substeps and iterations: fidelity/planner.h chooses for each muscle.
  std::optional<Tolerance> tolerance;
  std::string integrator = "local_global";  ///< explicit | xpbd | local_global | quasi_static
  /// none | penalty | printed | linear | exact | exact_always | zonal
  std::string volume = "exact";
  int substeps = 1;  ///< a frame; explicit: each in as many as its stability asks for
  int iterations = 3;
  Location location;
};

struct Bound {
  std::string quantity;  ///< the key's name: "volume_error"
  double limit = 0.0;
  Location location;
};

/// A scene as its file has it. Meshes and rig are still on disk.
struct Scene : World {
  std::filesystem::path file;    ///< as given
  std::filesystem::path folder;  ///< canonical; nothing is read outside it

  std::filesystem::path rig;  ///< a regular file; like all paths here absolute and canonical
  Location rig_location;
  SceneCharacter character;
  SceneCachedRig cached_rig;
  Clip clip;  ///< its time 0 is the first frame; it has one key at least
  Location clip_location;

  std::vector<SceneMuscle> muscles;
  std::vector<SceneCollider> colliders;
  SceneSkin skin;
  SceneSolver solver;
  struct : ContactDef {
    Location location;                                            ///< of `ignore`
    std::vector<std::pair<std::string, NodeMap>> thickness_maps;  ///< by name, m
  } contact;
  SceneRender render;
  struct {
    bool double_precision = false;
  } output;
  std::vector<Bound> bounds;
  std::vector<std::string> warnings;
};

}  // namespace thew::sim
