// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// What presses on a skin from outside.
struct Props {
  std::vector<Collider> colliders;
  double gap = 0.0;    ///< m, which the skin keeps from them
  double reach = 0.0;  ///< m; nodes that lie deeper in them stay where they are
};

/// Moves nodes of a skin that are nearer to props than the gap out to it, and marks them. Contact
/// keeps the flesh below farther from the props, so that there is room.
void leave_props(const Props& props, Points& x, std::vector<char>& marked);
/// Marks nodes that are nearer to props than the gap.
void mark_at_props(const Props& props, const Points& x, std::vector<char>& marked);

}  // namespace thew::skin
