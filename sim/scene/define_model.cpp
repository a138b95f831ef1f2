// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/define_model.h"

#include <algorithm>
#include <iterator>

#include "muscles/tube.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/text.h"
#include "sim/maps/node_map.h"
#include "sim/scene/define_character.h"

namespace thew::sim {
namespace {

// The value of the enum whose word it is.
template <typename Enum, size_t kCount>
Enum named(const std::string& word, const char* const (&words)[kCount], Enum otherwise) {
  const auto found = std::find(std::begin(words), std::end(words), word);
  return found == std::end(words) ? otherwise : static_cast<Enum>(found - std::begin(words));
}

// Implicit steps are exact in each iteration anyway. Zones hold the exact volume of the whole too.
VolumeMethod volume_method(const std::string& word, Integrator integrator) {
  const VolumeMethod method = named(word, kVolumeMethods, VolumeMethod::kExact);
  const bool is_explicit = integrator == Integrator::kExplicit;
  return method == VolumeMethod::kExactAlways && !is_explicit ? VolumeMethod::kExact : method;
}

int body_index(const Skeleton& skeleton, const std::string& name, const std::string& location) {
  const int body = find_body(skeleton, name);
  if (body >= 0) return body;
  throw Error(ErrorCode::kUsage, location + ": body \"" + name + "\" is not in the rig" +
                                     did_you_mean(name, skeleton.body_names));
}

MusclePath muscle_path(const Skeleton& skeleton, const Pose& bind_pose, const SceneMuscle& scene,
                       const std::string& location) {
  MusclePath path;
  for (const ScenePathPoint& point : scene.path) {
    path.points.push_back({body_index(skeleton, point.body, location), point.position});
    if (!point.with.empty()) {
      const int with = body_index(skeleton, point.with, point.location);
      share_turn(with, point.share, bind_pose, path.points.back());
    }
  }
  for (const SceneWrap& wrap : scene.wraps) {
    path.wraps.push_back({wrap.segment, body_index(skeleton, wrap.body, location), wrap.centre,
                          wrap.axis.normalized(), wrap.radius, wrap.turn});
  }
  return path;
}

// By node: the body that holds it, or -1.
std::vector<int> held_nodes(const Skeleton& skeleton, const SceneMuscle& scene,
                            const TriMesh& mesh) {
  std::vector<int> held(mesh.vertices.size(), -1);
  for (const SceneFixed& fixed : scene.fixed) {
    const std::string location = fixed.location + ": muscle \"" + scene.name + "\"";
    const int body = body_index(skeleton, fixed.body, location);
    int count = 0;
    for (size_t i = 0; i < held.size(); ++i) {
      const Vec3& p = mesh.vertices[i];
      if (held[i] >= 0 || (p.array() < fixed.low.array()).any() ||
          (p.array() > fixed.high.array()).any()) {
        continue;
      }
      held[i] = body;
      ++count;
    }
    if (count == 0) {
      throw Error(ErrorCode::kUsage, location + ": no node lies in the box that \"" + fixed.body +
                                         "\" holds; widen it");
    }
  }
  return held;
}

MuscleDef define_muscle(const Skeleton& skeleton, const Pose& bind_pose, const SceneMuscle& scene,
                        const Lengths& lengths, ImportedMesh& imported) {
  const std::string location = scene.location + ": muscle \"" + scene.name + "\"";
  MuscleDef def;
  static_cast<MuscleSettings&>(def) = scene;
  def.name = scene.name;
  def.location = scene.location;
  def.swells = scene.shape == SceneMuscle::Shape::kTarget;
  def.path = muscle_path(skeleton, bind_pose, scene, location);
  def.belly = scene.belly;
  def.twist_from = scene.twist_from;
  const bool has_path = !def.path.points.empty();
  if (has_path) def.belly = belly_of(def, bind_pose);
  if (scene.mesh.empty()) {
    def.mesh = make_tube(trace_path(def.path, bind_pose), scene.profile.around, scene.profile.rings,
                         scene.profile.radius);
  } else {
    imported = import_closed_mesh_whole(scene.mesh, scene.mesh_to_rest);
    def.mesh = imported.mesh;
    def.order = imported.order;
  }
  // Without a path there is no axis: all nodes are at its beginning.
  std::vector<double> u(def.mesh.vertices.size(), 0.0);
  if (has_path) u = belly_coordinates(def.mesh, def.path, bind_pose, def.belly, lengths);
  const MappedMesh mapped{def.mesh, imported, scene.mesh, scene.mesh_to_rest, &u};
  NodeMap weights = scene.weights;
  if (!weights.given()) weights.location = location;
  def.weights = map_values(weights, mapped);
  if (scene.stiffness.given()) {
    def.stiffness = map_values(scene.stiffness, mapped);
    take_constant(def.stiffness, def.material.stiffness);
  }
  if (!has_path) def.fixed_to = held_nodes(skeleton, scene, def.mesh);
  return def;
}

// What contact keeps free over muscles and bones, by node.
void define_thickness(const Scene& scene, const std::vector<ImportedMesh>& imported,
                      ModelDef& def) {
  for (const auto& [name, map] : scene.contact.thickness_maps) {
    std::vector<double> values;
    for (size_t m = 0; m < def.muscles.size(); ++m) {
      const SceneMuscle& muscle = scene.muscles[m];
      if (muscle.name != name) continue;
      NodeMap own = map;
      if (muscle.mirror) mirror_map(own);
      values = map_values(
          own, {def.muscles[m].mesh, imported[m], muscle.mesh, muscle.mesh_to_rest, nullptr});
    }
    for (const Bone& bone : def.bones) {
      if (bone.name == name) values = map_values(map, {bone.in_body, {}});
    }
    double constant = 0.0;
    const bool everywhere = take_constant(values, constant);
    if (everywhere || values.empty()) {  // a name that is none is told of as a number's is
      def.contact.thickness.push_back({name, constant});
    } else {
      def.contact.thicknesses.push_back({name, std::move(values)});
    }
  }
}

void define_skin(const Scene& scene, SkinDef& def) {
  const SceneSkin& skin = scene.skin;
  def.skinned = skin.skinned;
  def.ignore = skin.ignore;
  def.settings = skin.settings;
  def.location = skin.skinned ? scene.rig.string() : skin.mesh.string();
  if (skin.mesh.empty()) return;
  const ImportedMesh imported = import_closed_mesh_whole(skin.mesh, Eigen::Affine3d::Identity());
  def.mesh = imported.mesh;
  const auto by_node = [&](double number, const NodeMap& map) {
    if (map.given()) return map_values(map, {def.mesh, imported, skin.mesh});
    return std::vector<double>(def.mesh.vertices.size(), number);
  };
  if (skin.fat >= 0.0 || skin.fat_map.given()) def.maps.fat = by_node(skin.fat, skin.fat_map);
  def.maps.slide = by_node(skin.slide, skin.slide_map);
}

std::vector<Bone> bones_of(const Skeleton& skeleton) {
  std::vector<Bone> bones;
  for (int body = 0; body < skeleton.size(); ++body) {
    for (size_t k = 0; k < skeleton.visuals[body].size(); ++k) {
      const Skeleton::Visual& visual = skeleton.visuals[body][k];
      Bone bone;
      bone.body = body;
      bone.name = skeleton.body_names[body] + (k == 0 ? "" : "_" + std::to_string(k));
      bone.in_body = import_closed_mesh(visual.mesh_file);
      for (Vec3& p : bone.in_body.vertices) p = visual.in_body * Vec3(visual.scale.cwiseProduct(p));
      check_positions(visual.mesh_file, bone.in_body.vertices);
      bones.push_back(std::move(bone));
    }
  }
  return bones;
}

SolverSettings solver_of(const Scene& scene) {
  SolverSettings solver;
  solver.integrator = integrator_of(scene.solver.integrator);
  solver.volume = volume_method(scene.solver.volume, solver.integrator);
  solver.substeps = scene.solver.substeps;
  solver.iterations = scene.solver.iterations;
  solver.tolerance = scene.solver.tolerance;
  return solver;
}

}  // namespace

Integrator integrator_of(const std::string& word) {
  return named(word, kIntegrators, Integrator::kLocalGlobal);
}

ModelDef define_model(const Scene& scene) {
  ModelDef def;
  static_cast<World&>(def) = scene;
  def.source = scene.file.string();
  def.warnings = scene.warnings;
  def.solver = solver_of(scene);
  def.contact = scene.contact;
  if (scene.character.given) {
    def.character = define_character(scene, def.skeleton, def.warnings);
  } else {
    def.skeleton = import_urdf(scene.rig, scene.folder);
  }
  def.clip = scene.clip;
  def.clip_location = scene.clip_location;
  Pose bind_pose;
  forward_kinematics(def.skeleton, std::vector<double>(def.skeleton.size(), 0.0), bind_pose);
  std::vector<ImportedMesh> imported(scene.muscles.size());
  for (size_t m = 0; m < scene.muscles.size(); ++m) {
    const SceneMuscle& muscle = scene.muscles[m];
    def.muscles.push_back(
        define_muscle(def.skeleton, bind_pose, muscle, times(Lengths{}, scene.size), imported[m]));
    if (scene.solver.volume == "zonal") def.muscles.back().zones = muscle.zones;
  }
  def.bones = bones_of(def.skeleton);
  for (Bone& bone : character_bones(scene, def.skeleton)) def.bones.push_back(std::move(bone));
  define_thickness(scene, imported, def);
  define_skin(scene, def.skin);
  return def;
}

Model build_model(const Scene& scene) { return build_model(define_model(scene)); }

}  // namespace thew::sim
