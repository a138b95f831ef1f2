// SPDX-License-Identifier: Apache-2.0
#include "sim/model.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "muscles/tube.h"
#include "muscles/volume.h"
#include "rig/math.h"
#include "rig/mesh_import.h"
#include "rig/text.h"
#include "rig/urdf_import.h"
#include "sim/character_rig.h"
#include "sim/model_hash.h"
#include "sim/muscle_weights.h"

namespace thew {
namespace {

int body_index(const Skeleton& skeleton, const std::string& name, const std::string& place) {
  const int body = find_body(skeleton, name);
  if (body >= 0) return body;
  throw Error(ExitCode::kUsage, place + ": body \"" + name + "\" is not in the rig" +
                                    did_you_mean(name, skeleton.body_names));
}

MusclePath muscle_path(const Skeleton& skeleton, const SceneMuscle& scene) {
  const std::string place = scene.place + ": muscle \"" + scene.name + "\"";
  MusclePath path;
  for (const ScenePathPoint& point : scene.path) {
    path.points.push_back({body_index(skeleton, point.body, place), point.position});
  }
  for (const SceneWrap& wrap : scene.wraps) {
    path.wraps.push_back({wrap.segment, body_index(skeleton, wrap.body, place), wrap.centre,
                          wrap.axis.normalized(), wrap.radius, wrap.turn});
  }
  return path;
}

// Nodes outside the belly, its two bounding rings included, go with the path. The tolerance lets
// rings lie a little askew to the rounded path.
std::vector<char> driven_nodes(const CarriedShape& shape) {
  const double tolerance = 0.02 * (shape.belly[1] - shape.belly[0]);
  std::vector<char> driven(shape.along.size());
  for (size_t i = 0; i < driven.size(); ++i) {
    driven[i] =
        shape.along[i] < shape.belly[0] + tolerance || shape.along[i] > shape.belly[1] - tolerance;
  }
  return driven;
}

// What of the authored weights the multiplier goes by.
std::vector<double> multiplier_weights(const Muscle& muscle, const std::string& place) {
  const bool soft_body = !muscle.shape.held.empty();
  const double taper = muscle.swells ? 0.15 : 0.30;  // of the belly: weights alone need more
  std::vector<double> weights(muscle.authored_weights.size(), 0.0);
  for (size_t i = 0; i < weights.size(); ++i) {
    if (muscle.driven[i]) continue;
    weights[i] = muscle.authored_weights[i];
    if (soft_body) continue;
    const double u = belly_coordinate(muscle.shape, static_cast<int>(i));
    weights[i] *= smoothstep(0.0, taper, u) * smoothstep(0.0, taper, 1.0 - u);
  }
  try {
    return normalised_weights(weights, muscle.driven);
  } catch (const std::invalid_argument& error) {
    throw Error(ExitCode::kUsage, place + ": " + error.what());
  }
}

Skyline spring_matrix(const Springs& springs, double shape, const std::vector<char>& driven) {
  Skyline matrix = make_skyline(static_cast<int>(driven.size()), springs.nodes, driven);
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double stiffness = (1.0 + shape) * springs.stiffness[k];
    add_entry(matrix, a, a, stiffness);
    add_entry(matrix, b, b, stiffness);
    add_entry(matrix, a, b, -stiffness);
  }
  return matrix;
}

std::vector<double> contact_stiffness(const Skyline& matrix) {
  constexpr double kShare = 0.2;  // of the springs' at the node
  std::vector<double> stiffness(matrix.position.size(), 0.0);
  for (size_t node = 0; node < stiffness.size(); ++node) {
    const int i = matrix.position[node];
    if (i >= 0) stiffness[node] = kShare * matrix.values[matrix.start[i + 1] - 1];
  }
  return stiffness;
}

// By node the body that holds it, -1 none.
std::vector<int> held_nodes(const Skeleton& skeleton, const SceneMuscle& scene,
                            const TriMesh& mesh) {
  std::vector<int> held(mesh.vertices.size(), -1);
  for (const SceneFixed& fixed : scene.fixed) {
    const std::string place = fixed.place + ": muscle \"" + scene.name + "\"";
    const int body = body_index(skeleton, fixed.body, place);
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
      throw Error(ExitCode::kUsage,
                  place + ": no node lies in the box that \"" + fixed.body + "\" holds; widen it");
    }
  }
  return held;
}

// Where few nodes have to give all the volume back they are torn out of the surface, whatever the
// integrator: none may move more than so many times what it would under even weights.
void spread_weights(const Rows& x, Muscle& muscle) {
  constexpr double kMostShare = 3.0;
  Rows gradient;
  volume_gradient(x, muscle.rest.triangles, gradient);
  std::vector<double> share;
  for (size_t i = 0; i < x.size(); ++i) {
    share.push_back(to_vec(gradient[i]).squaredNorm() / muscle.mass[i]);
  }
  muscle.weight_floor = tame_weights(muscle.weights, share, muscle.driven, kMostShare);
}

std::vector<int> bodies_of(const CarriedShape& shape) {
  std::set<int> bodies;
  for (const PathPoint& point : shape.path.points) bodies.insert(point.body);
  for (const WrapCylinder& wrap : shape.path.wraps) bodies.insert(wrap.body);
  for (int body : shape.held) {
    if (body >= 0) bodies.insert(body);
  }
  return {bodies.begin(), bodies.end()};
}

// Springs, masses, weights: what follows from mesh, carried shape and driven nodes.
void finish_building(const std::vector<Vec3>& fibres, const std::string& place, Muscle& muscle) {
  const SpringMaterial& material = muscle.settings.material;
  for (char driven : muscle.driven) muscle.free_nodes.push_back(!driven);
  muscle.bodies = bodies_of(muscle.shape);
  muscle.springs = make_springs(muscle.rest, fibres, material);
  muscle.rings = make_ring_springs(muscle.rest.triangles, muscle.driven, muscle.springs);
  for (size_t k = 0; k < muscle.springs.nodes.size(); ++k) {
    auto [node, other] = muscle.springs.nodes[k];
    if (muscle.driven[node] == muscle.driven[other]) continue;
    if (muscle.driven[node]) std::swap(node, other);
    muscle.anchored.push_back({node, other, muscle.springs.stiffness[k]});
  }
  muscle.mass = lumped_masses(muscle.rest, material.density);
  muscle.highest_frequency_squared =
      highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven);
  muscle.weights = multiplier_weights(muscle, place);
  const Rows x = to_rows(muscle.rest.vertices);
  muscle.rest_volume = enclosed_volume(x, muscle.rest.triangles);
  spread_weights(x, muscle);
  try {
    muscle.stiffness = spring_matrix(muscle.springs, material.shape, muscle.driven);
    muscle.contact_stiffness = contact_stiffness(muscle.stiffness);
  } catch (const std::length_error& error) {
    throw Error(ExitCode::kUsage, place + ": " + error.what());
  }
}

Muscle build_soft_body(const Skeleton& skeleton, const Pose& bind_pose, const SceneMuscle& scene) {
  const std::string place = scene.place + ": muscle \"" + scene.name + "\"";
  Muscle muscle;
  muscle.name = scene.name;
  muscle.settings = scene;
  muscle.swells = false;
  const ImportedMesh imported = import_closed_mesh_whole(scene.mesh, scene.mesh_place);
  muscle.rest = imported.mesh;
  muscle.order = imported.order;
  muscle.surface =
      make_surface(muscle.rest.triangles, static_cast<int>(muscle.rest.vertices.size()));
  const std::vector<int> held = held_nodes(skeleton, scene, muscle.rest);
  muscle.shape = make_held_shape(muscle.rest, held, bind_pose);
  for (int body : held) muscle.driven.push_back(body >= 0);
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 0) == muscle.driven.end()) {
    throw Error(ExitCode::kUsage,
                place + ": every node is held; make the boxes of [fixed] smaller");
  }
  const std::vector<double> u(muscle.rest.vertices.size(), 0.0);  // no axis: all at its beginning
  muscle.authored_weights = authored_weights(scene, muscle.rest, u, imported, place);
  finish_building({}, place, muscle);
  return muscle;
}

Muscle build_muscle(const Skeleton& skeleton, const Pose& bind_pose, const SceneMuscle& scene,
                    const Lengths& lengths) {
  if (scene.path.empty()) return build_soft_body(skeleton, bind_pose, scene);
  const std::string place = scene.place + ": muscle \"" + scene.name + "\"";
  Muscle muscle;
  muscle.name = scene.name;
  muscle.settings = scene;
  const MusclePath path = muscle_path(skeleton, scene);
  std::array<double, 2> belly = scene.belly;
  const double length = trace_path(path, bind_pose).length;
  if (belly[1] <= belly[0]) belly = {0.1 * length, 0.9 * length};  // not given
  if (belly[0] < 0.0 || belly[1] > length) {
    throw Error(ExitCode::kUsage, place + ": belly reaches beyond the path, which is " +
                                      std::to_string(length) + " m long at rest");
  }
  if (scene.twist_from >= length) {
    throw Error(ExitCode::kUsage, place + ": twist_from lies beyond the path, which is " +
                                      std::to_string(length) + " m long at rest; give less");
  }
  ImportedMesh imported;
  if (scene.mesh.empty()) {
    muscle.rest = make_tube(trace_path(path, bind_pose), scene.profile.around, scene.profile.rings,
                            scene.profile.radius);
  } else {
    imported = import_closed_mesh_whole(scene.mesh, scene.mesh_place);
    muscle.rest = imported.mesh;
    muscle.order = imported.order;
  }
  muscle.surface =
      make_surface(muscle.rest.triangles, static_cast<int>(muscle.rest.vertices.size()));
  muscle.authored_weights = authored_weights(
      scene, muscle.rest, belly_coordinates(muscle.rest, path, bind_pose, belly, lengths), imported,
      place);
  muscle.shape = make_carried_shape(muscle.rest, path, bind_pose, belly, muscle.authored_weights,
                                    scene.twist_from, lengths);
  muscle.swells = scene.shape == SceneMuscle::Shape::kTarget;
  muscle.driven = driven_nodes(muscle.shape);
  const CarriedPose rest = carry_pose(muscle.shape, bind_pose);
  std::vector<Vec3> fibres(muscle.rest.vertices.size());
  for (size_t i = 0; i < fibres.size(); ++i) {
    Vec3 point;
    curve_at(muscle.shape, rest, muscle.shape.along[i], point, fibres[i]);
  }
  finish_building(fibres, place, muscle);
  return muscle;
}

std::vector<Bone> load_bones(const Skeleton& skeleton) {
  std::vector<Bone> bones;
  for (int body = 0; body < skeleton.size(); ++body) {
    for (size_t k = 0; k < skeleton.visuals[body].size(); ++k) {
      const Skeleton::Visual& visual = skeleton.visuals[body][k];
      Bone bone;
      bone.body = body;
      bone.name = skeleton.body_names[body] + (k == 0 ? "" : "_" + std::to_string(k));
      bone.in_body = import_closed_mesh(visual.mesh_file);
      for (Vec3& p : bone.in_body.vertices) p = visual.in_body * Vec3(visual.scale.cwiseProduct(p));
      check_places(visual.mesh_file, bone.in_body.vertices);
      bone.surface =
          make_surface(bone.in_body.triangles, static_cast<int>(bone.in_body.vertices.size()));
      bones.push_back(std::move(bone));
    }
  }
  return bones;
}

void prepare_contact(Model& model) {
  const double spacing = model.scene.contact.settings.spacing;
  for (Muscle& muscle : model.muscles) {
    muscle.held_points =
        held_points(muscle.surface, to_rows(muscle.rest.vertices), &muscle.free_nodes, spacing);
  }
  for (Bone& bone : model.bones) {
    const Rows x = to_rows(bone.in_body.vertices);
    bone.held_points = held_points(bone.surface, x, nullptr, spacing);
    bone.surface.convex = is_convex(bone.surface, x);
  }
}

// Which collider it is.
size_t collider_named(const Model& model, const char* key, const std::string& name) {
  std::vector<std::string> names;
  for (const Muscle& muscle : model.muscles) names.push_back(muscle.name);
  for (const Bone& bone : model.bones) names.push_back(bone.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<size_t>(found - names.begin());
  throw Error(ExitCode::kUsage, model.scene.file.string() + ": [contact] " + key + " names \"" +
                                    name + "\", which is no muscle or bone" +
                                    did_you_mean(name, names));
}

void set_thickness(Model& model) {
  for (const auto& [name, metres] : model.scene.contact.thickness) {
    const size_t i = collider_named(model, "thickness", name), muscles = model.muscles.size();
    (i < muscles ? model.muscles[i].thickness : model.bones[i - muscles].thickness) = metres;
  }
}

std::vector<std::vector<char>> ignored_pairs(const Model& model) {
  std::vector<std::vector<char>> ignore(model.muscles.size(),
                                        std::vector<char>(model.colliders(), 0));
  for (const auto& [a, b] : model.scene.contact.ignore) {
    const size_t i = collider_named(model, "ignore", a), j = collider_named(model, "ignore", b);
    if (i < ignore.size()) ignore[i][j] = 1;
    if (j < ignore.size()) ignore[j][i] = 1;
  }
  for (size_t m = 0; m < ignore.size(); ++m) ignore[m][m] = 1;
  for (const std::string& name : model.scene.contact.self) {
    const size_t i = collider_named(model, "self", name);
    if (i >= ignore.size()) {
      throw Error(ExitCode::kUsage, model.scene.file.string() + ": [contact] self names \"" + name +
                                        "\", which is a bone and does not fold; remove it");
    }
    ignore[i][i] = 0;
  }
  return ignore;
}

void build_skin(const Pose& bind_pose, Model& model) {
  const TriMesh mesh = import_closed_mesh(model.scene.skin.mesh);
  std::vector<Rows> rows;
  std::vector<Bvh> trees;
  std::vector<Collider> below;
  std::vector<int> bodies;
  rows.reserve(model.colliders());
  trees.reserve(model.colliders());
  const auto add = [&](const Surface& surface, int body, auto&& position, size_t nodes) {
    Rows& x = rows.emplace_back();
    for (size_t i = 0; i < nodes; ++i) x.push_back(to_row(position(i)));
    trees.push_back(build_bvh(surface, x));
    below.push_back({&surface, &trees.back(), &x, nullptr});
    bodies.push_back(body);
  };
  for (const Muscle& muscle : model.muscles) {
    add(
        muscle.surface, -1, [&](size_t i) { return muscle.rest.vertices[i]; },
        muscle.rest.vertices.size());
  }
  for (const Bone& bone : model.bones) {
    add(
        bone.surface, bone.body,
        [&](size_t i) { return Vec3(bind_pose[bone.body] * bone.in_body.vertices[i]); },
        bone.in_body.vertices.size());
  }
  try {
    model.skin =
        bind_skin(mesh, model.skeleton, bind_pose, below, bodies, model.scene.skin.settings);
  } catch (const std::length_error& error) {
    throw Error(ExitCode::kInput, model.scene.skin.mesh.string() + ": " + error.what());
  }
  model.has_skin = true;
}

// What a bake of these muscles takes in memory, about: matrices, nodes, and what contact remembers
// of each node and collider. Asked before more of them are made.
void check_memory(const Model& model, const SceneMuscle& last) {
  constexpr std::size_t kMost = std::size_t{4} << 30, kNode = 3000, kRemembered = 12;  // bytes
  const std::size_t colliders = model.scene.muscles.size() + model.bones.size();
  std::size_t bytes = 0;
  for (const Muscle& muscle : model.muscles) {
    bytes += matrix_bytes(muscle.stiffness) +
             muscle.rest.vertices.size() * (kNode + kRemembered * colliders);
  }
  if (bytes <= kMost) return;
  throw Error(ExitCode::kUsage, last.place + ": with muscle \"" + last.name +
                                    "\" the scene takes " + std::to_string(bytes >> 20) +
                                    " MiB of memory, more than " + std::to_string(kMost >> 20) +
                                    "; use coarser meshes or fewer muscles");
}

// Along the belly or, without a path, along the longest axis.
void divide(Muscle& muscle) {
  const int count = muscle.settings.zones;
  if (count == 1) return;
  std::vector<double> along;
  if (!muscle.shape.held.empty()) {
    along = longest_axis_coordinates(muscle.rest);
  } else {
    for (size_t i = 0; i < muscle.rest.vertices.size(); ++i) {
      along.push_back(belly_coordinate(muscle.shape, static_cast<int>(i)));
    }
  }
  try {
    muscle.zones = make_volume_zones(muscle.rest, along, count);
  } catch (const std::invalid_argument& error) {
    throw Error(ExitCode::kUsage,
                muscle.settings.place + ": muscle \"" + muscle.name + "\": " + error.what());
  }
}

// Implicit steps are exact in each iteration. Zones are an exact volume and more besides.
VolumeMethod volume_method(const std::string& word, bool is_explicit) {
  if (word == "exact_always" && is_explicit) return VolumeMethod::kExactAlways;
  if (word == "none") return VolumeMethod::kNone;
  if (word == "printed") return VolumeMethod::kPrinted;
  if (word == "linear") return VolumeMethod::kLinear;
  if (word == "penalty") return VolumeMethod::kPenalty;
  return VolumeMethod::kExact;
}

}  // namespace

Integrator integrator_of(const std::string& word) {
  if (word == "explicit") return Integrator::kExplicit;
  if (word == "xpbd") return Integrator::kXpbd;
  if (word == "quasi_static") return Integrator::kQuasiStatic;
  return Integrator::kLocalGlobal;
}

Model build_model(const Scene& scene) {
  Model model;
  model.scene = scene;
  model.lengths = times(Lengths{}, scene.size);
  model.warnings = scene.warnings;
  model.integrator = integrator_of(scene.solver.integrator);
  model.volume = volume_method(scene.solver.volume, model.integrator == Integrator::kExplicit);
  if (scene.character.given) {
    build_character(scene, model);
  } else {
    model.skeleton = import_urdf(scene.rig, scene.folder);
  }
  check_clip(model.scene.clip, model.skeleton, scene.clip_place, model.warnings);
  Pose bind_pose;
  forward_kinematics(model.skeleton, std::vector<double>(model.skeleton.size(), 0.0), bind_pose);
  for (const SceneMuscle& muscle : scene.muscles) {
    model.muscles.push_back(build_muscle(model.skeleton, bind_pose, muscle, model.lengths));
    if (scene.solver.volume == "zonal") divide(model.muscles.back());
    check_memory(model, muscle);
    if (!(model.muscles.back().weight_floor > 0.0)) continue;
    model.warnings.push_back(
        muscle.place + ": muscle \"" + muscle.name +
        "\": its weights lie on too few nodes; a floor under all of them keeps "
        "these from being torn out");
  }
  model.bones = load_bones(model.skeleton);
  load_character_bones(scene, model);
  prepare_contact(model);
  model.ignore = ignored_pairs(model);
  set_thickness(model);
  if (!scene.skin.mesh.empty()) build_skin(bind_pose, model);
  if (scene.skin.skinned) build_skinned(model);
  hash_model(model);
  return model;
}

}  // namespace thew
