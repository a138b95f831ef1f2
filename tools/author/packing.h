// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"
#include "tools/author/bones.h"
#include "tools/author/table.h"

namespace thew::tools {

/// The muscles' meshes at rest, in the humerus' frame, packed beside one another and the bones so
/// that there is room at rest and with the elbow bent: closed tubes, first the pole at the origin,
/// then ring by ring, then the pole at the insertion, numbered in the order in which the triangles
/// name them. Each encloses the table's volume.
std::vector<TriMesh> pack_muscles(const std::vector<TableMuscle>& muscles, const Skeleton& skeleton,
                                  const std::vector<BoneShape>& bones);

}  // namespace thew::tools
