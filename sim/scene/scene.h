// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "muscles/weights.h"
#include "sim/scene/model_def.h"

namespace thew::sim {

/// Where in the scene file something stands: "arm.toml:12".
using Location = std::string;

/// A belly without a mesh: a tube along the path (rings as in assets: `around` nodes a ring,
/// `rings` rings and two poles), radius given against the path coordinate 0..1.
struct TubeProfile {
  int around = 20, rings = 17;
  std::vector<std::array<double, 2>> radius;  ///< (u, m)
};

struct ScenePathPoint {
  std::string body;
  Vec3 position = Vec3::Zero();
  Location location = {};
  std::string with = {};  ///< empty: it goes with `body` alone; see PathPoint
  double share = 1.0;
};
struct SceneWrap {
  int segment = 0;
  std::string body;
  Vec3 centre = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0.0, turn = 1.0;
  Location location = {};
};

/// Nodes of a soft body that a body of the rig holds: those in a box of the rest pose (m).
struct SceneFixed {
  std::string body;
  Vec3 low = Vec3::Constant(-1e12), high = Vec3::Constant(1e12);
  Location location = {};
};

/// Weights that keep to places, so that they outlive edits of the mesh: each vertex takes that of
/// the nearest place, which is no farther than the tolerance.
struct SceneWeights {
  std::vector<Vec3> places;  ///< m, in the rest pose
  std::vector<double> weights;
  double tolerance = 1e-3;     ///< m
  int channel = -1;            ///< 0..3: of the colours of `mesh`; -1: none
  std::filesystem::path mesh;  ///< whose colours; empty: the muscle's own
};

struct SceneMuscle : MuscleSettings {
  enum class Shape { kTarget, kWeights };
  std::string name;
  Location location;
  std::filesystem::path mesh;                                ///< empty: `profile` is used
  Eigen::Affine3d mesh_place = Eigen::Affine3d::Identity();  ///< from the file to the rest pose
  TubeProfile profile;
  /// Empty: a soft body, which springs of rest length and its volume alone shape.
  std::vector<ScenePathPoint> path;
  std::vector<SceneWrap> wraps;
  std::vector<SceneFixed> fixed;  ///< of a soft body; the first box that a node lies in counts
  /// m along the rest path, first and last ring of the belly; both 0: not given
  std::array<double, 2> belly = {0.0, 0.0};
  double twist_from = 0.0;  ///< m along the rest path; beyond it the insertion's twist is taken
  WeightProfile weights;
  std::vector<double> node_weights;  ///< authored per node (from text), overrides the profile
  SceneWeights painted;              ///< as well, by place or colour
  Shape shape = Shape::kTarget;
  Vec3 colour = Vec3(0.62, 0.16, 0.13);
  int zones = 4;  ///< solver.volume = "zonal": each keeps its volume
};

struct SceneView {
  std::string name;           ///< one of those below: also what is drawn
  std::string show = "skin";  ///< skin | muscles | weights | cutaway
  Vec3 eye = Vec3(1, 0, 0), target = Vec3::Zero(), up = Vec3::UnitY();
  double field_of_view = 30.0;  ///< degrees, vertical
  Vec3 light = Vec3::Zero();    ///< towards the key light; zero: over the eye's left shoulder
  /// cutaway: unit normal n and d (m); the skin is open where n . p > d for all, p in the rest
  /// pose.
  std::vector<std::array<double, 4>> cut;
};
inline constexpr std::size_t kMostCuts = 6;

struct SceneRender {
  int width = 960, height = 540;
  std::vector<SceneView> views;
};

/// A character's forearm, one body, as the two bones of an arm: the ulna follows the hinge without
/// the body's roll about its length, the radius turns by that roll about the line from its head,
/// which the ulna holds, to the wrist.
struct SceneForearm {
  std::string ulna, radius;                         ///< bodies that there are then besides
  Vec3 head = Vec3::Zero(), wrist = Vec3::UnitY();  ///< m, in the body's frame
};
/// A joint that turns a body of a character about one axis, so that keys can drive it.
struct SceneHinge {
  std::string name, body;
  Vec3 axis = Vec3::UnitX();   ///< unit, in the body's frame
  double at_bind = 0.0;        ///< rad, its angle in the bind pose; muscles are made at 0
  Vec3 along = Vec3::UnitY();  ///< unit, in the body's frame: its length
  double roll = 0.0;  ///< rad about it from the bind pose, in the pose that the muscles are made in
  std::array<double, 2> range = {-3.2, 3.2};  ///< rad
  std::optional<SceneForearm> forearm;
  Location location;
};
struct SceneBone {
  std::string name, body;
  std::filesystem::path mesh;  ///< in the body's frame
  Location location;
};
/// What [rig] says where its file is a character's.
struct SceneCharacter {
  bool given = false;
  double scale = 1.0;
  std::string animation;         ///< of the character; empty: the clip's keys, or `motion`
  std::filesystem::path motion;  ///< BVH
  std::vector<std::array<std::string, 2>> motion_names;  ///< its body -> the character's
  std::vector<SceneHinge> hinges;
  std::vector<SceneBone> bones;
};

struct Bound {
  /// volume_error, substep_volume_error, penetration, poke_through, attachment_gap
  std::string quantity;
  double limit = 0.0;
  Location location;
};

/// A scene as its file has it: meshes, rigs and clips still on disk.
struct Scene : World {
  std::filesystem::path file;    ///< as given
  std::filesystem::path folder;  ///< canonical; nothing is read outside it

  std::filesystem::path rig;  ///< like all paths here absolute, canonical, a regular file
  Location rig_location;
  SceneCharacter character;
  Clip clip;  ///< sampled with time 0 at the first frame; has one key at least
  Location clip_location;

  std::vector<SceneMuscle> muscles;
  struct {
    std::filesystem::path mesh;  ///< empty: no skin
    bool skinned = false;        ///< the character's own mesh by its own weights; no `mesh`
    SkinSettings settings;
    Location location;
  } skin;
  struct {
    /// In place of integrator, substeps and iterations: fidelity_planner.h chooses for each muscle.
    std::optional<Tolerance> tolerance;
    std::string integrator = "local_global";  ///< explicit | xpbd | local_global | quasi_static
    /// none | penalty | printed | linear | exact | exact_always | zonal
    std::string volume = "exact";
    int substeps = 1;  ///< a frame; explicit: each in as many as its stability asks for
    int iterations = 3;
    Location location;
  } solver;
  struct : ContactDef {
    Location location;  ///< of `ignore`
  } contact;
  SceneRender render;
  struct {
    bool double_precision = false;
  } output;
  std::vector<Bound> bounds;
  std::vector<std::string> warnings;
};

}  // namespace thew::sim
