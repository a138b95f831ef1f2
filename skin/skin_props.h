// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/contact/collider.h"
#include "skin/skin_model.h"

namespace thew::skin {

/// What presses on a skin from outside.
struct Props {
  std::vector<Collider> colliders;
  double gap = 0.0;    ///< m, which the skin keeps from them
  double reach = 0.0;  ///< m; what lies deeper in them, or they in the skin, stays where it is
};

/// Moves nodes of a skin that are nearer to props than the gap out to it, and its faces off the
/// points of props that are, and marks these nodes in `held`. Contact keeps the flesh below farther
/// from the props, so that there is room.
void leave_props(const Props& props, const Surface& surface, SkinState& state);
/// Marks nodes that are nearer to props than the gap.
void mark_at_props(const Props& props, const Points& x, std::vector<char>& marked);

}  // namespace thew::skin
