// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/define_model.h"

#include <algorithm>
#include <iterator>

#include "muscles/tube.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/text.h"
#include "sim/cache/cached_mesh.h"
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

std::vector<Bone> bones_of(const Skeleton& skeleton) {
  std::vector<Bone> bones;
  for (int body = 0; body < skeleton.size(); ++body) {
    for (size_t k = 0; k < skeleton.visuals[body].size(); ++k) {
      const Skeleton::Visual& visual = skeleton.visuals[body][k];
      Bone bone;
      bone.body = body;
      bone.name = skeleton.body_names[body] + (k == 0 ? "" : "_" + std::to_string(k));
      bone.in_body = import_bone(visual.mesh_file);
      for (Vec3& p : bone.in_body.vertices) p = visual.in_body * Vec3(visual.scale.cwiseProduct(p));
      check_positions(visual.mesh_file, bone.in_body.vertices);
      bones.push_back(std::move(bone));
    }
  }
  return bones;
}

// s of the clip in a frame of the scene; at the first where none is given.
double clip_time(const Scene& scene, const std::optional<double>& frame) {
  return frame ? (*frame - scene.first_frame) / scene.fps : 0.0;
}

void warn_of_end(const Scene& scene, const std::string& what, double end,
                 std::vector<std::string>& warnings) {
  constexpr double kSlack = 1e-3;  // frames; MDD rounds its seconds
  const double frame = scene.first_frame + end * scene.fps;
  if (frame > scene.last_frame - kSlack) return;
  warnings.push_back(what + ": its samples end at frame " + number_text(frame) +
                     "; it stays as it is there");
}

std::shared_ptr<const MeshMotion> motion_of(const Scene& scene, const std::string& what,
                                            const CachedMesh& mesh,
                                            const std::optional<double>& start,
                                            std::vector<std::string>& warnings) {
  auto motion = std::make_shared<MeshMotion>(
      motion_of(mesh.rest.vertices, mesh.samples, clip_time(scene, start)));
  warn_of_end(scene, what, motion->times.back(), warnings);
  return motion;
}

// Where a bone meets another: of a few vertices of each those that are nearest to each other.
struct Joint {
  double distance = 1e300;  // m
  Vec3 at = Vec3::Zero();   // m, of the second, in its body
};
Joint joint_between(const Bone& one, const Transform& pose, const Bone& other,
                    const Transform& other_pose) {
  constexpr size_t kFew = 64;
  Joint joint;
  const Transform from_other = pose.inverse() * other_pose;
  const auto few = [](const Bone& bone, auto&& take) {
    const std::vector<Vec3>& x = bone.in_body.vertices;
    for (size_t i = 0; i < x.size(); i += 1 + x.size() / kFew) take(x[i]);
  };
  few(other, [&](const Vec3& q) {
    const Vec3 to = from_other * q;
    few(one, [&](const Vec3& p) {
      if ((p - to).norm() < joint.distance) joint = {(p - to).norm(), q};
    });
  });
  return joint;
}

// The bone that moves least, in which the others hang.
size_t stillest(const std::vector<Bone>& bones) {
  const auto way = [](const Bone& bone) {
    double most = 0.0;
    for (const Transform& pose : bone.motion->poses) {
      for (const Vec3& p : {bone.in_body.vertices.front(), bone.in_body.vertices.back()}) {
        most = std::max(most, (pose * p - bone.motion->poses.front() * p).norm());
      }
    }
    return most;
  };
  return static_cast<size_t>(
      std::min_element(bones.begin(), bones.end(),
                       [&](const Bone& a, const Bone& b) { return way(a) < way(b); }) -
      bones.begin());
}

void add_body(const std::string& name, int parent, const Transform& in_parent, const Vec3& pivot,
              Skeleton& skeleton) {
  skeleton.body_names.push_back(name);
  skeleton.parent.push_back(parent);
  skeleton.joint_in_parent.push_back(in_parent);
  skeleton.joint_names.emplace_back();
  skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
  skeleton.joint_axes.push_back(Vec3::UnitX());
  skeleton.lower.push_back(0.0);
  skeleton.upper.push_back(0.0);
  skeleton.visuals.emplace_back();
  skeleton.pivots.resize(skeleton.body_names.size(), Vec3::Zero());
  skeleton.pivots.back() = pivot;
}

// Gives each bone a body. These are a tree, which the way to the first frame needs: each hangs in
// the one that is nearest to it in the bind pose (Prim 1957).
void hang_up(const Pose& bind, std::vector<Bone>& bones, Skeleton& skeleton) {
  std::vector<size_t> of;  // by body
  std::vector<Joint> nearest(bones.size());
  std::vector<int> parent(bones.size(), -1);
  for (size_t next = stillest(bones); of.size() < bones.size();) {
    const int up = parent[next];
    const Transform in_parent = up < 0 ? bind[next] : bind[of[up]].inverse() * bind[next];
    add_body(bones[next].name, up, in_parent, nearest[next].at, skeleton);
    bones[next].body = skeleton.size() - 1;
    of.push_back(next);
    size_t best = bones.size();
    for (size_t b = 0; b < bones.size(); ++b) {
      if (bones[b].body >= 0) continue;
      const Joint joint = joint_between(bones[next], bind[next], bones[b], bind[b]);
      if (joint.distance < nearest[b].distance) {
        nearest[b] = joint;
        parent[b] = bones[next].body;
      }
      if (best == bones.size() || nearest[b].distance < nearest[best].distance) best = b;
    }
    next = best;
  }
}

std::vector<Bone> cached_rig(const Scene& scene, Skeleton& skeleton,
                             std::vector<std::string>& warnings) {
  constexpr double kSaid = 1e-4;  // m, of a man's bone
  const SceneCachedRig& rig = scene.cached_rig;
  std::vector<CachedMesh> meshes;
  if (!scene.rig.empty()) meshes = read_baked_bones(scene.rig, rig.scale);
  for (const SceneBone& bone : scene.character.bones) {
    meshes.push_back(read_cached_mesh(bone.mesh, bone.cache, scene.fps, rig.scale, Pieces::kAny));
    meshes.back().name = bone.name;
  }
  std::vector<Bone> bones;
  Pose bind;
  for (const CachedMesh& mesh : meshes) {
    const std::string what = scene.clip_location + ": bone \"" + mesh.name + "\"";
    const auto motion = motion_of(scene, what, mesh, rig.start, warnings);
    if (motion->bend > kSaid * scene.size) {
      warnings.push_back(
          what + " bends by up to " + number_text(1e3 * motion->bend) + " mm, most in frame " +
          number_text(scene.first_frame + motion->times[motion->bent_most] * scene.fps) +
          "; muscles are fixed to its nearest rigid motion, and meet its surface");
    }
    const bool as_in_file = !rig.bind && scene.rig.empty();
    bind.push_back(as_in_file ? Transform::Identity()
                              : pose_at(*motion, rig.bind ? clip_time(scene, rig.bind)
                                                          : motion->times.front()));
    bones.push_back({mesh.name, -1, mesh.rest, motion});
  }
  hang_up(bind, bones, skeleton);
  return bones;
}

Bone collider_of(const Scene& scene, const SceneCollider& collider, Skeleton& skeleton,
                 std::vector<std::string>& warnings) {
  Bone bone{collider.name, skeleton.size(), {}};
  bone.prop = true;
  if (collider.cache.empty()) {
    bone.in_body =
        import_closed_mesh(collider.mesh, Eigen::Affine3d(Eigen::Scaling(collider.scale)));
  } else {
    const CachedMesh mesh =
        collider.mesh.empty()
            ? read_baked_mesh(collider.cache, {collider.part, {}}, collider.scale)
            : read_cached_mesh(collider.mesh, collider.cache, scene.fps, collider.scale);
    const std::string what = collider.location + ": collider \"" + collider.name + "\"";
    bone.motion = motion_of(scene, what, mesh, collider.start, warnings);
    bone.in_body = mesh.rest;
  }
  if (find_body(skeleton, collider.name) >= 0) {
    throw Error(ErrorCode::kUsage, collider.location + ": a body is called \"" + collider.name +
                                       "\" already; give another name");
  }
  const Transform first = bone.motion ? bone.motion->poses.front() : Transform::Identity();
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : bone.in_body.vertices) middle += p;
  middle /= static_cast<double>(bone.in_body.vertices.size());
  add_body(collider.name, -1, first, middle, skeleton);
  return bone;
}

// The shape of a layer by frame, as samples alone.
std::shared_ptr<const MeshMotion> skin_motion(const Scene& scene, SkinDef& skin,
                                              std::vector<std::string>& warnings) {
  const CachedMesh mesh = scene.skin.mesh.empty()
                              ? read_baked_mesh(scene.skin.cache, {"", BakeMesh::Kind::kSkin}, 1.0)
                              : read_cached_mesh(scene.skin.mesh, scene.skin.cache, scene.fps, 1.0);
  auto motion = std::make_shared<MeshMotion>();
  for (size_t k = 0; k < mesh.samples.times.size(); ++k) {
    motion->times.push_back(clip_time(scene, scene.skin.start) + mesh.samples.times[k]);
    motion->shapes.push_back(to_points(mesh.samples.positions[k]));
  }
  motion->poses.assign(motion->times.size(), Transform::Identity());
  warn_of_end(scene, scene.skin.location + ": the skin's cache", motion->times.back(), warnings);
  skin.mesh = mesh.rest;
  return motion;
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

// `character` is that of a skinned skin, else null.
void define_skin(const Scene& scene, const Character* character, std::vector<std::string>& warnings,
                 SkinDef& def) {
  const SceneSkin& skin = scene.skin;
  def.skinned = skin.skinned;
  def.ignore = skin.ignore;
  def.settings = skin.settings;
  def.location = skin.skinned ? scene.rig.string() : skin.mesh.string();
  if (!skin.cache.empty()) {
    def.location = skin.cache.string();
    def.motion = skin_motion(scene, def, warnings);
    return;
  }
  if (skin.mesh.empty() && !character) return;
  ImportedMesh imported;
  if (!character) {
    imported = import_closed_mesh_whole(skin.mesh, Eigen::Affine3d::Identity());
    def.mesh = imported.mesh;
  }
  const TriMesh& mesh = character ? character->mesh : def.mesh;
  MappedMesh mapped{mesh, imported, character ? scene.rig : skin.mesh};
  mapped.character = character;
  mapped.to_rest = Eigen::Scaling(character ? scene.character.scale : 1.0);
  const auto by_node = [&](double number, const NodeMap& map, double otherwise) {
    mapped.otherwise = otherwise;
    if (map.given()) return map_values(map, mapped);
    return std::vector<double>(mesh.vertices.size(), number);
  };
  const SceneSkin plain;
  if (skin.fat >= 0.0 || skin.fat_map.given()) {
    def.maps.fat = by_node(skin.fat, skin.fat_map, plain.fat);
  }
  def.maps.slide = by_node(skin.slide, skin.slide_map, plain.slide);
}

}  // namespace

Integrator integrator_of(const std::string& word) {
  return named(word, kIntegrators, Integrator::kLocalGlobal);
}

ModelDef define_model(const Scene& scene) {
  const SharedReader reader;
  ModelDef def;
  static_cast<World&>(def) = scene;
  def.source = scene.file.string();
  def.warnings = scene.warnings;
  def.contact = scene.contact;
  if (scene.character.given) {
    def.character = define_character(scene, def.skeleton, def.warnings);
  } else if (scene.cached_rig.given) {
    def.bones = cached_rig(scene, def.skeleton, def.warnings);
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
  }
  solve_as(scene, def);
  for (Bone& bone : bones_of(def.skeleton)) def.bones.push_back(std::move(bone));
  if (scene.character.given) {
    for (Bone& bone : character_bones(scene, def.skeleton)) def.bones.push_back(std::move(bone));
  }
  for (const SceneCollider& collider : scene.colliders) {
    def.bones.push_back(collider_of(scene, collider, def.skeleton, def.warnings));
  }
  if (def.character) def.character->skin_pose.resize(def.skeleton.size(), 0.0);
  define_thickness(scene, imported, def);
  const bool skinned = scene.skin.skinned;
  define_skin(scene, skinned ? &def.character->character : nullptr, def.warnings, def.skin);
  return def;
}

void solve_as(const Scene& scene, ModelDef& def) {
  def.solver = solver_of(scene);
  const bool zonal = scene.solver.volume == "zonal";
  for (size_t m = 0; m < def.muscles.size(); ++m) {
    def.muscles[m].zones = zonal ? scene.muscles[m].zones : MuscleDef{}.zones;
  }
}

Model build_model(const Scene& scene) { return build_model(define_model(scene)); }

}  // namespace thew::sim
