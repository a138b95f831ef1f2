// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// The last of a step: parts the triangles of muscles that still cross one another, bones or
/// themselves, opens edges at which a muscle is folded, and restores the volumes. In a few rounds;
/// a muscle that they do not part stays where it was. Velocities stay as they are, so that no
/// energy comes of it. Whether anything crossed or was folded.
bool part_muscles(const Model& model, Parallel& parallel, State& state);

}  // namespace thew::sim
