// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

/// A closed skin at rest over muscles and bones (all in the humerus' frame): a tube along the arm
/// from a cap over the shoulder to a cap over the palm, nowhere nearer to them than `clearance`.
TriMesh arm_skin(const std::vector<TriMesh>& below, double clearance);

}  // namespace thew::tools
