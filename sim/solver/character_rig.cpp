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

}  // namespace thew::sim
