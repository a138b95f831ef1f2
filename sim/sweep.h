// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/health.h"

namespace thew {

/// After the rig has moved and before contacts are looked for: the node that has gone farthest
/// beyond a bone's surface in this step, as the bone sees it, if that is deeper than
/// contact.max_depth, from where it might come out on the other side; and in how many parts the
/// step has to be taken. Along each way the distance to the bone is marched (sphere tracing, Hart
/// 1996), so that nothing is missed however fast it is. Fits the bones' trees where it needs them.
std::optional<Trouble> find_leap(const Model& model, State& state);

}  // namespace thew
