// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

// A rig that is a character's file, in each frame.

/// Ulna and radius from where humerus and forearm are, and how they lay at rest.
void pose_forearm(const Skeleton& skeleton, const Forearm& forearm, Pose& pose);

/// The nearest body above that a bone's mesh is fixed to, -1 where there is none.
int bone_above(const Model& model, int body);

/// Whether an animation moves all bodies, and not keys the hinges.
bool is_animated(const Model& model);
/// All bodies at `time` (s); before 0 they go from the rest pose to the clip's first. After the
/// keyed joints have been applied.
void drive_character(const Model& model, double time, State& state);

}  // namespace thew::sim
