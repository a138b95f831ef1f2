// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

// Poses what a file moves, in each frame: a character's bodies, and bones and props from caches.

/// The nearest ancestor of the body that carries a bone's mesh; -1 where none does.
int bone_above(const Model& model, int body);

/// Whether the character is moved by an animation of all its bodies; otherwise keys move its
/// hinges.
bool is_animated(const Model& model);
/// Sets all bodies, after forward kinematics of the keyed joints.
void drive_character(const Model& model, const WayPoint& at, State& state);

/// Whether any cached bone of the rig is elsewhere in the first frame than in the bind pose.
bool leaves_bind_pose(const Model& model);
/// Sets the bodies of cached bones and props, after forward kinematics, which gives the bind pose.
/// On the way from it to a pose of the clip, bones turn against one another evenly; a prop goes
/// through its own motion up to there, so that it comes as it was made to come.
void pose_cached(const Model& model, const WayPoint& at, State& state);
/// Moves the nodes of a bone that bends to where it is `at`, and sets what a step needs to know of
/// it; after pose_cached(). Its body has moved if any node has.
void bend_bone(const Bone& bone, const WayPoint& at, State& state, BoneState& now);
/// Puts it where it is `at`, in the pose before the step.
void place_bent(const Bone& bone, const WayPoint& at, const State& state, BoneState& now);

}  // namespace thew::sim
