// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/build_model.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/model_hash.h"
#include "skin/contact/face_contact.h"
#include "skin/contact/kept_out.h"
#include "skin/contact/way_around.h"

namespace thew::sim {
namespace {

// Roughly the memory that a bake of these muscles takes: matrices, nodes, and what contact
// remembers of each node and collider that has come near it, of which kNear are more than an arm
// has. It is asked for before they are made: 1.8 GB for 64 arms side by side, which take 1.5.
void check_memory(const ModelDef& def, const std::vector<Muscle>& muscles) {
  constexpr std::size_t kMost = std::size_t{4} << 30, kNode = 3000, kRemembered = 12;  // bytes
  constexpr std::size_t kNear = 100;
  const std::size_t colliders = std::min(kNear, def.muscles.size() + def.bones.size());
  std::size_t bytes = 0;
  for (const Muscle& muscle : muscles) {
    bytes += matrix_bytes(muscle.stiffness) +
             muscle.rest.vertices.size() * (kNode + kRemembered * colliders);
  }
  if (bytes <= kMost) return;
  const Muscle& last = muscles.back();
  throw Error(ErrorCode::kUsage, last.location + ": with muscle \"" + last.name +
                                     "\" the scene takes " + std::to_string(bytes >> 20) +
                                     " MiB of memory, more than " + std::to_string(kMost >> 20) +
                                     "; use coarser meshes or fewer muscles");
}

// Moment arm -dL/dq at values all over a joint's range, by central differences, with the other
// joints at rest.
std::vector<std::array<double, 2>> moment_arms(const Model& model, const MusclePath& path,
                                               int body) {
  constexpr int kValues = 65;
  constexpr double kStep = 1e-4;  // rad or m
  const double low = std::max(model.skeleton.lower[body], -kPi);
  const double high = std::min(model.skeleton.upper[body], kPi);
  std::vector<double> joints(model.skeleton.size(), 0.0);
  Pose pose;
  const auto length_at = [&](double value) {
    joints[body] = value;
    forward_kinematics(model.skeleton, joints, pose);
    if (model.character) {
      pose_limbs(model.skeleton, model.character->forearms, model.character->scapulae, pose);
    }
    return trace_path(path, pose).length;
  };
  std::vector<std::array<double, 2>> arms;
  for (int k = 0; k < kValues; ++k) {
    const double q = low + (high - low) * k / (kValues - 1);
    arms.push_back({q, (length_at(q - kStep) - length_at(q + kStep)) / (2.0 * kStep)});
    if (!(high > low)) break;
  }
  return arms;
}

// Finds what an activation by a joint names.
void tie_to_joint(const Model& model, Muscle& muscle) {
  if (!muscle.settings.by_joint) return;
  JointActivation& by = *muscle.settings.by_joint;
  const std::string begin = (muscle.location.empty() ? "" : muscle.location + ": ") + "muscle \"" +
                            muscle.name + "\": its activation ";
  by.body = find_joint(model.skeleton, by.joint);
  if (by.body < 0 || model.skeleton.joint_types[by.body] == Skeleton::JointType::kFixed) {
    throw Error(ErrorCode::kUsage, begin + "goes by joint \"" + by.joint +
                                       "\", which the rig does not have or which is fixed" +
                                       did_you_mean(by.joint, model.skeleton.joint_names));
  }
  if (!by.speed.empty() && model.solver.integrator == Integrator::kQuasiStatic &&
      !model.solver.tolerance) {
    throw Error(ErrorCode::kUsage,
                begin +
                    "goes by speed, which a pose by itself does not have; give a curve, or "
                    "take another integrator than \"quasi_static\"");
  }
  if (!by.load) return;
  by.load->index = find_body(model.skeleton, by.load->body);
  if (by.load->index < 0) {
    throw Error(ErrorCode::kUsage, begin + "has a load on body \"" + by.load->body +
                                       "\", which is not in the rig" +
                                       did_you_mean(by.load->body, model.skeleton.body_names));
  }
  by.moment_arm = moment_arms(model, muscle.shape.path, by.body);
}

void build_muscles(const ModelDef& def, const Pose& bind_pose, Model& model) {
  for (const MuscleDef& muscle : def.muscles) {
    model.muscles.push_back(build_muscle(muscle, bind_pose, model.lengths));
    check_memory(def, model.muscles);
    tie_to_joint(model, model.muscles.back());
    if (!(model.muscles.back().weight_floor > 0.0)) continue;
    model.warnings.push_back(
        muscle.location + ": muscle \"" + muscle.name +
        "\": its weights lie on too few nodes; a floor under all of them keeps "
        "these from being torn out");
  }
}

ContactSurface contact_surface(const std::string& name, int body, const TriMesh& mesh,
                               const std::vector<char>* free_nodes, double spacing) {
  ContactSurface out{
      name, body, make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size())),
      {},   0.0,  {}};
  const Points x = to_points(mesh.vertices);
  out.rigid_points = rigid_points(out.surface, x, free_nodes, spacing);
  return out;
}

void build_surfaces(Model& model) {
  const double spacing = model.contact.settings.spacing;
  for (const Muscle& muscle : model.muscles) {
    model.surfaces.push_back(
        contact_surface(muscle.name, -1, muscle.rest, &muscle.free_nodes, spacing));
  }
  for (const Bone& bone : model.bones) {
    if (bone.body < 0 || bone.body >= model.skeleton.size()) {
      throw Error(ErrorCode::kUsage, model.source + ": bone \"" + bone.name +
                                         "\" is fixed to body " + std::to_string(bone.body) +
                                         ", which the skeleton does not have");
    }
    model.surfaces.push_back(contact_surface(bone.name, bone.body, bone.in_body, nullptr, spacing));
    Surface& surface = model.surfaces.back().surface;
    surface.convex = !bone.bends() && is_convex(surface, to_points(bone.in_body.vertices));
  }
}

std::vector<int> cached_bones(const Model& model) {
  std::vector<int> cached;
  for (size_t b = 0; b < model.bones.size(); ++b) {
    if (model.bones[b].motion && !model.bones[b].prop) cached.push_back(static_cast<int>(b));
  }
  std::sort(cached.begin(), cached.end(),
            [&](int a, int b) { return model.bones[a].body < model.bones[b].body; });
  return cached;
}

// The index of the collider of this name.
size_t collider_named(const Model& model, const char* key, const std::string& name) {
  std::vector<std::string> names;
  for (const ContactSurface& surface : model.surfaces) names.push_back(surface.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<size_t>(found - names.begin());
  throw Error(ErrorCode::kUsage, model.source + ": " + key + " names \"" + name +
                                     "\", which is no muscle or bone" + did_you_mean(name, names));
}

std::vector<std::vector<char>> ignored_pairs(const ContactDef& contact, const Model& model) {
  std::vector<std::vector<char>> ignore(model.muscles.size(),
                                        std::vector<char>(model.colliders(), 0));
  for (const auto& [a, b] : contact.ignore) {
    const size_t i = collider_named(model, "[contact] ignore", a),
                 j = collider_named(model, "[contact] ignore", b);
    if (i < ignore.size()) ignore[i][j] = 1;
    if (j < ignore.size()) ignore[j][i] = 1;
  }
  for (size_t m = 0; m < ignore.size(); ++m) ignore[m][m] = 1;
  for (const std::string& name : contact.self) {
    const size_t i = collider_named(model, "[contact] self", name);
    if (i >= ignore.size()) {
      throw Error(ErrorCode::kUsage, model.source + ": [contact] self names \"" + name +
                                         "\", which is a bone and does not fold; remove it");
    }
    ignore[i][i] = 0;
  }
  return ignore;
}

// Tendons pass around the bones that their muscles meet.
void lead_around_bones(const Pose& bind_pose, Model& model) {
  if (!model.contact.enabled) return;
  auto bones = std::make_shared<std::vector<RigidBone>>();
  std::vector<int> colliders;
  for (size_t b = 0; b < model.bones.size(); ++b) {
    const Bone& bone = model.bones[b];
    if (bone.bends() || bone.prop) continue;
    const size_t c = model.muscles.size() + b;
    bones->push_back(
        rigid_bone(bone.body, model.surfaces[c].surface, to_points(bone.in_body.vertices)));
    colliders.push_back(static_cast<int>(c));
  }
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    Muscle& muscle = model.muscles[m];
    if (!muscle.has_path()) continue;
    std::vector<int> which;
    for (size_t k = 0; k < colliders.size(); ++k) {
      if (!model.ignore[m][colliders[k]]) which.push_back(static_cast<int>(k));
    }
    pass_around(bones, which, bind_pose, model.size, muscle.shape);
    keep_out(bones, std::move(which), muscle.rest.triangles, muscle.driven, bind_pose, model.size,
             muscle.shape);
  }
}

// The muscles and bones below a skin, at rest.
struct Below {
  std::vector<Points> x;
  std::vector<Bvh> trees;
  std::vector<Collider> colliders;
  std::vector<int> bodies;

  // `carried` has the positions (m) of the muscles.
  Below(const Model& model, int count, const Pose& pose, const std::vector<Points>& carried) {
    x.resize(count);
    place(model, pose, carried);
    trees.reserve(count);
    for (int c = 0; c < count; ++c) {
      const ContactSurface& it = model.surfaces[c];
      trees.push_back(build_bvh(it.surface, x[c]));
      colliders.push_back({&it.surface, &trees.back(), &x[c], nullptr});
      bodies.push_back(it.body);
    }
  }

  // To another pose, in the same trees.
  void move(const Model& model, const Pose& pose, const std::vector<Points>& carried) {
    place(model, pose, carried);
    for (size_t c = 0; c < x.size(); ++c) refit_bvh(model.surfaces[c].surface, x[c], trees[c]);
  }

 private:
  void place(const Model& model, const Pose& pose, const std::vector<Points>& carried) {
    for (size_t c = 0; c < x.size(); ++c) {
      const int body = model.surfaces[c].body;
      if (body < 0) {
        x[c] = carried[c];
        continue;
      }
      x[c].clear();
      for (const Vec3& p : model.bones[c - carried.size()].in_body.vertices) {
        x[c].push_back(to_point(Vec3(pose[body] * p)));
      }
    }
  }
};

std::vector<char> felt_by_skin(const SkinDef& skin, const Model& model) {
  std::vector<char> feels(model.surfaces.size(), 0);
  std::fill(feels.begin(), feels.begin() + below_skin(model), 1);  // props lie above it
  for (const std::string& name : skin.ignore) {
    const size_t c = collider_named(model, "[skin] ignore", name);
    if (c < model.muscles.size()) {
      throw Error(ErrorCode::kUsage, model.source + ": [skin] ignore names \"" + name +
                                         "\", which is a muscle; give bones");
    }
    feels[c] = 0;
  }
  return feels;
}

void check_size(const std::vector<double>& map, size_t nodes, const std::string& what) {
  if (map.empty() || map.size() == nodes) return;
  throw Error(ErrorCode::kUsage, what + " has " + std::to_string(map.size()) +
                                     " values for a mesh of " + std::to_string(nodes) +
                                     " nodes; give one per node");
}

void build_layer(const SkinDef& skin, const Pose& bind_pose, Model& model) {
  std::vector<Points> rest;
  for (const Muscle& muscle : model.muscles) rest.push_back(to_points(muscle.rest.vertices));
  const Below below(model, below_skin(model), bind_pose, rest);
  check_size(skin.maps.fat, skin.mesh.vertices.size(), skin.location + ": fat");
  check_size(skin.maps.slide, skin.mesh.vertices.size(), skin.location + ": slide");
  try {
    model.skin = bind_skin(skin.mesh, model.skeleton, bind_pose, below.colliders, below.bodies,
                           skin.settings, skin.maps);
    model.skin_motion = skin.motion;
  } catch (const std::length_error& error) {
    throw Error(ErrorCode::kInput, skin.location + ": " + error.what());
  }
  model.has_skin = true;
}

// By body of the character, whether it has a bone or hangs on one that has.
std::vector<char> limbs_of(const Model& model) {
  std::vector<char> limbs(model.skeleton.size(), 0);
  for (const Bone& bone : model.bones) limbs[bone.body] = 1;
  for (int b = 0; b < model.skeleton.size(); ++b) {
    const int parent = model.skeleton.parent[b];
    if (parent >= 0 && limbs[parent]) limbs[b] = 1;
  }
  return limbs;
}

// By body, whether some bodies that carry the layer of a character's skin hang on its joint, and
// others do not: the joints of legs bend none of an arm's.
std::vector<char> bends_of(const Model& model) {
  const SkinnedSkin& skin = *model.skinned;
  std::vector<int> below(model.skeleton.size(), 0);
  for (const auto& carriers : skin.carriers) {
    for (const auto& [link, share] : carriers) below[skin.weights.links[link].body] = 1;
  }
  const int all = std::accumulate(below.begin(), below.end(), 0);
  for (int b = model.skeleton.size() - 1; b > 0; --b) {  // parents come first
    const int parent = model.skeleton.parent[b];
    if (parent >= 0) below[parent] += below[b];
  }
  std::vector<char> bends;
  for (const int count : below) bends.push_back(count > 0 && count < all);
  return bends;
}

// The muscles as their paths carry them, and the bones, in a pose of the joints of a character.
struct LimbPose {
  Pose pose;
  std::vector<Points> muscles;
  std::vector<Affine> bodies;

  LimbPose(const Model& model, const std::vector<double>& joints) {
    const CharacterRig& rig = *model.character;
    forward_kinematics(model.skeleton, joints, pose);
    pose_limbs(model.skeleton, rig.forearms, rig.scapulae, pose);
    for (const Muscle& muscle : model.muscles) {
      carried_positions(muscle.shape, carry_pose(muscle.shape, pose), muscle.swells,
                        muscles.emplace_back());
    }
    for (size_t b = 0; b < rig.stretch.size(); ++b) bodies.push_back(pose[b] * rig.stretch[b]);
  }
};

std::vector<Collider> felt_of(const Model& model, const Below& below) {
  std::vector<Collider> felt;
  for (int c = 0; c < model.colliders(); ++c) {
    if (model.skin_feels[c]) felt.push_back(below.colliders[c]);
  }
  return felt;
}

// Brings the layer from the pose in which it is tied to the muscles to the one in which they are
// made and every simulation begins.
void find_start(Below& below, Model& model) {
  SkinnedSkin& skin = *model.skinned;
  const std::vector<double>& from = model.character->skin_pose;
  double farthest = 0.0;
  for (const double angle : from) farthest = std::max(farthest, std::abs(angle));
  const int steps = static_cast<int>(std::ceil(farthest / skin.settings.max_turn));
  const std::vector<Collider> felt = felt_of(model, below);
  SkinState layer = initial_layer(skin), shown = initial_skinned(skin);
  for (int k = 1; k <= steps; ++k) {
    std::vector<double> joints = from;
    for (double& angle : joints) angle *= 1.0 - static_cast<double>(k) / steps;
    const LimbPose at(model, joints);
    below.move(model, at.pose, at.muscles);
    step_skinned(skin, at.bodies, felt, {}, layer, shown);
  }
  skin.start = layer;
}

// The character's own skin, with the muscles under it. It is tied to them with its shoulders as it
// was modelled: where the arm hangs, the weights alone may have folded it into the muscles.
void build_skinned(const SkinDef& skin, Model& model) {
  const CharacterRig& rig = *model.character;
  const Character& character = rig.character;
  if (character.mesh.triangles.empty()) {
    throw Error(ErrorCode::kInput,
                skin.location + ": has no skin; export the character with its mesh");
  }
  const LimbPose at(model, rig.skin_pose);
  Below below(model, model.colliders(), at.pose, at.muscles);
  model.skinned =
      bind_skinned(character, at.bodies, felt_of(model, below), static_cast<int>(at.muscles.size()),
                   limbs_of(model), skin.settings, skin.maps);
  const auto& [fat, slide] = skin.maps;
  const bool painted = !fat.empty() || std::any_of(slide.begin(), slide.end(),
                                                   [](double value) { return value != 1.0; });
  if (painted && model.skinned->nodes.empty()) {
    model.warnings.push_back(skin.location +
                             ": no skin lies near a muscle of a limb, a body with a "
                             "bone or below one; fat and slide change nothing");
  }
  model.skin.surface.triangles = character.mesh.triangles;
  model.skin.rest = model.skinned->rest;
  model.has_skin = true;
  model.skin_bends = bends_of(model);
  find_start(below, model);
}

}  // namespace

Model build_model(const ModelDef& def) {
  Model model;
  static_cast<World&>(model) = def;
  model.source = def.source;
  model.lengths = times(Lengths{}, def.size);
  model.warnings = def.warnings;
  model.skeleton = def.skeleton;
  model.character = def.character;
  model.clip = def.clip;
  if (model.clip.times.empty()) model.clip.times = {0.0}, model.clip.values = {{}};
  check_clip(model.clip, model.skeleton, def.clip_location, model.warnings);
  model.solver = def.solver;
  model.contact = def.contact;
  Pose bind_pose;
  forward_kinematics(model.skeleton, std::vector<double>(model.skeleton.size(), 0.0), bind_pose);
  build_muscles(def, bind_pose, model);
  model.bones = def.bones;
  model.cached = cached_bones(model);
  build_surfaces(model);
  model.ignore = ignored_pairs(def.contact, model);
  lead_around_bones(bind_pose, model);
  const bool has_skin = def.skin.skinned || !def.skin.mesh.triangles.empty();
  for (int c = below_skin(model); has_skin && c < model.colliders(); ++c) {
    model.surfaces[c].thickness = def.skin.settings.thickness;  // room for the skin
  }
  for (const auto& [name, metres] : def.contact.thickness) {
    model.surfaces[collider_named(model, "[contact] thickness", name)].thickness = metres;
  }
  for (const auto& [name, by_node] : def.contact.thicknesses) {
    ContactSurface& surface = model.surfaces[collider_named(model, "[contact] thickness", name)];
    check_size(by_node, surface.surface.vertex_triangles.size(), "thickness of \"" + name + "\"");
    surface.thicknesses = by_node;
  }
  model.skin_feels = felt_by_skin(def.skin, model);
  if (!def.skin.mesh.triangles.empty()) build_layer(def.skin, bind_pose, model);
  if (def.skin.skinned) build_skinned(def.skin, model);
  hash_model(def, model);
  return model;
}

}  // namespace thew::sim
