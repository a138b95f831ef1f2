// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "rig/mesh.h"
#include "thew/mesh.h"

namespace thew::rig {

// Between the public arrays and the types inside.

/// Error(kUsage) where a length is no multiple of three.
TriMesh to_tri_mesh(std::span<const double> positions, std::span<const int> triangles);
/// Error(kUsage) where a triangle names a vertex that is not there.
void check_triangles(const TriMesh& mesh);

std::vector<double> to_array(const std::vector<Vec3>& points);
std::vector<int> to_array(const std::vector<Triangle>& triangles);
Mesh to_mesh(const TriMesh& mesh);

}  // namespace thew::rig
