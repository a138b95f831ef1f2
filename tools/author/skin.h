// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

/// A closed skin at rest over muscles and bones (all in the humerus' frame) and the flesh that the
/// twelve muscles do not stand for: from the edge of the chest, cut by a plane, to the fingers'
/// tips. Nowhere nearer to what is below than `clearance` (m).
TriMesh arm_skin(const std::vector<TriMesh>& below, double clearance);

}  // namespace thew::tools
