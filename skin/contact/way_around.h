// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "muscles/carried_shape.h"
#include "skin/contact/rigid_bone.h"

namespace thew::skin {

using muscles::CarriedShape;

/// Leads the tendons of a muscle around bones, since contact does not move them. Where the curve
/// comes nearer to a bone than in `rest_pose`, and nearer than the tendon is thick, it is pushed
/// away from the bone, and its neighbourhood with it; the ends of the path stay. The new curve
/// depends on the pose alone. `which` are the bones (indices) that the muscle meets, and `size` is
/// that of the body over a man's.
void pass_around(std::shared_ptr<const std::vector<RigidBone>> bones, std::vector<int> which,
                 const Pose& rest_pose, double size, CarriedShape& shape);

}  // namespace thew::skin
