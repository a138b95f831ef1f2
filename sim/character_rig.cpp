// SPDX-License-Identifier: Apache-2.0
#include "sim/character_rig.h"

#include <algorithm>

#include "rig/character_import.h"
#include "rig/math.h"
#include "rig/mesh_import.h"
#include "rig/text.h"

namespace thew {
namespace {

int body_of(const Skeleton& skeleton, const std::string& name, const Place& place) {
  const int body = find_body(skeleton, name);
  if (body >= 0) return body;
  throw Error(ExitCode::kUsage, place + ": body \"" + name + "\" is not in the character" +
                                    did_you_mean(name, skeleton.body_names) + "; correct the name");
}

void add_hinge(const SceneHinge& hinge, Skeleton& skeleton) {
  const int body = body_of(skeleton, hinge.body, hinge.place);
  skeleton.joint_names[body] = hinge.name;
  skeleton.joint_types[body] = Skeleton::JointType::kRevolute;
  const Mat3 roll = rotation_about(hinge.along, hinge.roll);
  skeleton.joint_axes[body] = roll.transpose() * hinge.axis;
  skeleton.lower[body] = hinge.range[0];
  skeleton.upper[body] = hinge.range[1];
  skeleton.joint_in_parent[body].linear() *= rotation_about(hinge.axis, -hinge.at_bind) * roll;
}

// A body that lies at rest as another does.
int add_body(const std::string& name, int like, const Place& place, Skeleton& skeleton) {
  if (find_body(skeleton, name) >= 0) {
    throw Error(ExitCode::kUsage,
                place + ": there is a body \"" + name + "\" already; give another name");
  }
  skeleton.body_names.push_back(name);
  skeleton.parent.push_back(skeleton.parent[like]);
  skeleton.joint_in_parent.push_back(skeleton.joint_in_parent[like]);
  skeleton.joint_names.emplace_back();
  skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
  skeleton.joint_axes.push_back(skeleton.joint_axes[like]);
  skeleton.lower.push_back(0.0);
  skeleton.upper.push_back(0.0);
  skeleton.visuals.emplace_back();
  return skeleton.size() - 1;
}

Forearm add_forearm(const SceneHinge& hinge, Skeleton& skeleton) {
  const SceneForearm& of = *hinge.forearm;
  const int body = find_body(skeleton, hinge.body);
  if (skeleton.parent[body] < 0) {
    throw Error(ExitCode::kUsage, hinge.place + ": body \"" + hinge.body +
                                      "\" hangs on none, and so is no forearm; remove forearm");
  }
  const int ulna = add_body(of.ulna, body, hinge.place, skeleton);
  return {body, ulna, add_body(of.radius, body, hinge.place, skeleton), of.head, of.wrist};
}

BodyClip named_animation(const Scene& scene, const Character& character) {
  std::vector<std::string> names;
  for (const BodyClip& clip : character.animations) {
    if (clip.name == scene.character.animation) return clip;
    names.push_back(clip.name);
  }
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  throw Error(ExitCode::kUsage, scene.clip_place + ": animation \"" + scene.character.animation +
                                    "\" is not in " + scene.rig.string() +
                                    did_you_mean(scene.character.animation, names) +
                                    "; it has: " + (all.empty() ? "none" : all));
}

BodyClip motion_of(const Scene& scene, const Character& character,
                   std::vector<std::string>& warnings) {
  const Character motion = import_character(scene.character.motion);
  if (motion.animations.empty()) {
    throw Error(ExitCode::kInput,
                scene.character.motion.string() + ": holds no motion; export it with its frames");
  }
  return retarget(motion, motion.animations[0], character, scene.character.motion_names,
                  scene.clip_place, warnings);
}

}  // namespace

void build_character(const Scene& scene, Model& model) {
  CharacterRig& rig = model.character.emplace();
  rig.character = import_character(scene.rig, scene.character.scale);
  const Character& character = rig.character;
  model.warnings.insert(model.warnings.end(), character.warnings.begin(), character.warnings.end());
  model.skeleton = character.skeleton;
  for (const SceneHinge& hinge : scene.character.hinges) add_hinge(hinge, model.skeleton);
  if (!scene.character.animation.empty()) rig.clip = named_animation(scene, character);
  if (!scene.character.motion.empty()) rig.clip = motion_of(scene, character, model.warnings);
  for (const SceneHinge& hinge : scene.character.hinges) {
    if (hinge.forearm) rig.forearms.push_back(add_forearm(hinge, model.skeleton));
  }
  Pose rest;
  forward_kinematics(model.skeleton, std::vector<double>(model.skeleton.size(), 0.0), rest);
  for (int b = 0; b < character.skeleton.size(); ++b) {
    rig.stretch.push_back(rigid_part(character.bind[b]).inverse() * character.bind[b]);
    rig.rest.push_back(rest[b] * rig.stretch[b]);
  }
}

void load_character_bones(const Scene& scene, Model& model) {
  for (const SceneBone& of_scene : scene.character.bones) {
    Bone bone;
    bone.name = of_scene.name;
    bone.body = body_of(model.skeleton, of_scene.body, of_scene.place);
    bone.in_body = import_closed_mesh(of_scene.mesh);
    bone.surface =
        make_surface(bone.in_body.triangles, static_cast<int>(bone.in_body.vertices.size()));
    model.bones.push_back(std::move(bone));
  }
}

void build_skinned(Model& model) {
  const CharacterRig& rig = *model.character;
  const size_t count = model.muscles.size();
  std::vector<Rows> rows(count);
  std::vector<Bvh> trees;
  trees.reserve(count);
  std::vector<Collider> below;
  for (size_t m = 0; m < count; ++m) {
    const Muscle& muscle = model.muscles[m];
    rows[m] = to_rows(muscle.rest.vertices);
    trees.push_back(build_bvh(muscle.surface, rows[m]));
    below.push_back({&muscle.surface, &trees[m], &rows[m], nullptr});
  }
  const Character& character = rig.character;
  if (character.mesh.triangles.empty()) {
    throw Error(ExitCode::kInput,
                model.scene.rig.string() + ": has no skin; export the character with its mesh");
  }
  model.skinned = bind_skinned(character.mesh, character.map_back, character.skin, rig.rest, below,
                               model.scene.skin.settings);
  model.skin.surface.triangles = character.mesh.triangles;
  model.skin.rest = model.skinned->rest;
  model.has_skin = true;
}

void hash_character(const Model& model, Hash& hash) {
  if (!model.character) return;
  const CharacterRig& rig = *model.character;
  const auto numbers = [&](const auto& list) {
    const double count = static_cast<double>(list.size());
    hash.add(&count, sizeof count);
    hash.add(list.data(), list.size() * sizeof list[0]);
  };
  const auto affines = [&](const std::vector<Affine>& list) {
    for (const Affine& one : list) hash.add(one.data(), 16 * sizeof(double));
  };
  affines(rig.rest);
  affines(rig.character.rest);
  for (const Forearm& forearm : rig.forearms) {
    for (const Vec3& p : {forearm.head, forearm.wrist}) hash.add(p.data(), 3 * sizeof(double));
  }
  const auto turns = [&](const std::vector<Eigen::Quaterniond>& list) {
    for (const auto& q : list) hash.add(q.coeffs().data(), 4 * sizeof(double));
  };
  const auto bent = [&](const auto& curve, const auto& add) {
    if (curve.way == CurveWay::kLinear) return;
    hash.add(&curve.way, sizeof curve.way);
    add(curve.slopes_in);
    add(curve.slopes_out);
  };
  for (const BodyTrack& track : rig.clip.tracks) {
    hash.add(&track.body, sizeof track.body);
    numbers(track.translation.times);
    numbers(track.translation.values);
    numbers(track.rotation.times);
    turns(track.rotation.values);
    numbers(track.scale.times);
    numbers(track.scale.values);
    bent(track.translation, numbers);
    bent(track.rotation, turns);
    bent(track.scale, numbers);
  }
  if (!model.skinned) return;
  numbers(model.skinned->weights.link);
  numbers(model.skinned->weights.weight);
  const SkinSettings& settings = model.scene.skin.settings;
  for (double value : {settings.reach, settings.bridging}) hash.add(&value, sizeof value);
}

bool is_animated(const Model& model) {
  return model.character && !model.character->clip.tracks.empty();
}

void pose_forearm(const Skeleton& skeleton, const Forearm& forearm, Pose& pose) {
  const Mat3 rest = pose[skeleton.parent[forearm.body]].linear() *
                    skeleton.joint_in_parent[forearm.body].linear();
  const Vec3& axis = skeleton.joint_axes[forearm.body];
  const Vec3 along = forearm.wrist.normalized();
  const Mat3 turn = rest.transpose() * pose[forearm.body].linear();
  // The hinge as far as it brings the length near where it is, and the least turn for the rest.
  const Vec3 now = turn * along, a = axis.cross(along), b = axis.cross(now);
  const Mat3 hinge = rotation_about(axis, arc_tan2(axis.dot(a.cross(b)), a.dot(b)));
  const Mat3 bent = least_turn(hinge * along, now) * hinge;
  const Eigen::Quaterniond rolled(Mat3(bent.transpose() * turn));
  const double roll = 2.0 * arc_tan2(rolled.vec().dot(along), rolled.w());
  Transform& ulna = pose[forearm.ulna];
  ulna = pose[forearm.body];
  ulna.linear() = rest * bent;
  Transform& radius = pose[forearm.radius];
  radius.linear() =
      ulna.linear() * rotation_about((forearm.wrist - forearm.head).normalized(), roll);
  radius.translation() = ulna * forearm.head - radius.linear() * forearm.head;
}

namespace {

void drive_bodies(const Model& model, double time, State& state) {
  const CharacterRig& rig = *model.character;
  if (is_animated(model)) {
    std::vector<Affine> now;
    animated_bodies(rig.character, rig.clip, std::max(time, 0.0), now);
    const double share =
        time >= 0.0 ? 1.0 : smoothstep(-model.scene.settle, -0.5 * model.scene.settle, time);
    if (share < 1.0) {
      blend_bodies(rig.character.skeleton, rig.rest, now, share, state.bodies);
    } else {
      state.bodies = std::move(now);
    }
    for (size_t b = 0; b < state.bodies.size(); ++b) state.pose[b] = rigid_part(state.bodies[b]);
    return;
  }
  state.bodies.resize(rig.stretch.size());
  for (size_t b = 0; b < state.bodies.size(); ++b) state.bodies[b] = state.pose[b] * rig.stretch[b];
}

}  // namespace

void drive_character(const Model& model, double time, State& state) {
  drive_bodies(model, time, state);
  for (const Forearm& forearm : model.character->forearms) {
    pose_forearm(model.skeleton, forearm, state.pose);
  }
}

}  // namespace thew
