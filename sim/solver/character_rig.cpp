// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/character_rig.h"

#include <algorithm>

#include "rig/math.h"

namespace thew::sim {

bool is_animated(const Model& model) {
  return model.character && !model.character->clip.tracks.empty();
}

namespace {

void drive_bodies(const Model& model, const WayPoint& at, State& state) {
  const CharacterRig& rig = *model.character;
  if (is_animated(model)) {
    animated_bodies(rig.character, rig.clip, at.clip_time, state.bodies);
    if (at.share < 1.0) {
      state.bodies_of_clip = state.bodies;
      blend_bodies(rig.character.skeleton, rig.rest, state.bodies_of_clip, at.share, state.bodies);
    }
    for (size_t b = 0; b < state.bodies.size(); ++b) state.pose[b] = rigid_part(state.bodies[b]);
    return;
  }
  state.bodies.resize(rig.stretch.size());
  for (size_t b = 0; b < state.bodies.size(); ++b) state.bodies[b] = state.pose[b] * rig.stretch[b];
}

// Turns the humerus so that it points from shoulder to elbow. Where a twist bone between humerus
// and forearm bends as well, the humerus' own frame would leave the elbow out of joint.
void point_at_elbow(const Model& model, const Forearm& forearm, Pose& pose) {
  const int humerus = bone_above(model, forearm.body);
  if (humerus < 0 || humerus == model.skeleton.parent[forearm.body]) return;
  const CharacterRig& rig = *model.character;
  const Vec3 at_rest =
      rigid_part(rig.rest[humerus]).inverse() * Vec3(rig.rest[forearm.body].translation());
  Transform& bone = pose[humerus];
  const Vec3 axis = bone.linear() * at_rest,
             to_elbow = pose[forearm.body].translation() - bone.translation();
  if (!(axis.norm() > 0.0) || !(to_elbow.norm() > 0.0)) return;
  bone.linear() = least_turn(axis.normalized(), to_elbow.normalized()) * bone.linear();
}

}  // namespace

int bone_above(const Model& model, int body) {
  const auto has_bone = [&](int b) {
    return std::any_of(model.bones.begin(), model.bones.end(),
                       [&](const Bone& bone) { return bone.body == b; });
  };
  do {
    body = model.skeleton.parent[body];
  } while (body >= 0 && !has_bone(body));
  return body;
}

void drive_character(const Model& model, const WayPoint& at, State& state) {
  drive_bodies(model, at, state);
  for (const Forearm& forearm : model.character->forearms) {
    point_at_elbow(model, forearm, state.pose);
  }
  pose_limbs(model.skeleton, model.character->forearms, model.character->scapulae, state.pose);
}

namespace {

// s of a prop's motion on the way.
double prop_time(const WayPoint& at) {
  return at.share < 1.0 ? at.share * at.clip_time : at.clip_time;
}

// Sets `now.shape`. On the way a bone of the rig bends evenly.
void set_shape(const Bone& bone, const WayPoint& at, BoneState& now) {
  shape_at(*bone.motion, bone.prop ? prop_time(at) : at.clip_time, now.shape);
  if (bone.prop || at.share == 1.0) return;
  for (size_t i = 0; i < now.shape.size(); ++i) {
    const Point rest = to_point(bone.in_body.vertices[i]);
    now.shape[i] = rest + at.share * (now.shape[i] - rest);
  }
}

void place(const Transform& pose, const Points& shape, Points& x) {
  x.resize(shape.size());
  for (size_t i = 0; i < x.size(); ++i) x[i] = to_point(Vec3(pose * to_vec(shape[i])));
}

}  // namespace

bool leaves_bind_pose(const Model& model) {
  Pose bind;
  forward_kinematics(model.skeleton, std::vector<double>(model.skeleton.size(), 0.0), bind);
  return std::any_of(model.cached.begin(), model.cached.end(), [&](int b) {
    const Bone& bone = model.bones[b];
    const Vec3& p = bone.in_body.vertices.front();
    return (pose_at(*bone.motion, 0.0) * p - bind[bone.body] * p).norm() > kRigid;
  });
}

void pose_cached(const Model& model, const WayPoint& at, State& state) {
  Pose &pose = state.pose, &of_clip = state.cached_pose;
  of_clip.resize(pose.size());
  for (const Bone& bone : model.bones) {
    if (!bone.motion) continue;
    of_clip[bone.body] = pose_at(*bone.motion, bone.prop ? prop_time(at) : at.clip_time);
    if (bone.prop || at.share == 1.0) pose[bone.body] = of_clip[bone.body];
  }
  if (at.share == 1.0) return;
  for (const int b : model.cached) {
    const int body = model.bones[b].body, parent = model.skeleton.parent[body];
    const Transform& bind = model.skeleton.joint_in_parent[body];
    const Transform now = parent < 0 ? of_clip[body] : of_clip[parent].inverse() * of_clip[body];
    pose[body] = between(bind, now, at.share);
    if (parent >= 0) pose[body] = pose[parent] * pose[body];
  }
}

void bend_bone(const Bone& bone, const WayPoint& at, State& state, BoneState& now) {
  now.start.swap(now.x);
  now.x = now.shape;  // before
  set_shape(bone, at, now);
  now.bent = largest_distance(now.shape, now.x);
  place(state.pose[bone.body], now.shape, now.x);
  now.displacement = largest_distance(now.x, now.start);
  if (now.displacement > 0.0) state.body_moved[bone.body] = 1;
  now.fitted = false;
}

void place_bent(const Bone& bone, const WayPoint& at, const State& state, BoneState& now) {
  const Pose& pose = state.pose_before.empty() ? state.pose : state.pose_before;
  set_shape(bone, at, now);
  place(pose[bone.body], now.shape, now.x);
}

}  // namespace thew::sim
