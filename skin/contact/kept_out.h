// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "muscles/carried_shape.h"
#include "skin/contact/rigid_bone.h"

namespace thew::skin {

/// Keeps the nodes of a muscle that are `driven` (by node), and the edges that hang on them, out of
/// bones: they follow the carried shape, and contact does not move them. What lies deeper in a bone
/// than in `rest_pose` is moved out of it, by a millimetre of a man at most, in each pose by
/// itself. `which` are the bones (indices) that the muscle meets, and `size` is that of the body
/// over a man's.
void keep_out(std::shared_ptr<const std::vector<RigidBone>> bones, std::vector<int> which,
              const std::vector<Triangle>& triangles, const std::vector<char>& driven,
              const Pose& rest_pose, double size, muscles::CarriedShape& shape);

}  // namespace thew::skin
