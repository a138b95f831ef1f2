// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

// Poses a rig that comes from a character's file, in each frame.

/// The nearest ancestor of the body that carries a bone's mesh; -1 where none does.
int bone_above(const Model& model, int body);

/// Whether the character is moved by an animation of all its bodies; otherwise keys move its
/// hinges.
bool is_animated(const Model& model);
/// Sets all bodies, after forward kinematics of the keyed joints.
void drive_character(const Model& model, const WayPoint& at, State& state);

}  // namespace thew::sim
