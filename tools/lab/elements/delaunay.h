// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

using Tetrahedron = std::array<int, 4>;

struct TetMesh {
  std::vector<Vec3> vertices;
  std::vector<Tetrahedron> tetrahedra;  ///< positive volume
};

/// Delaunay tetrahedra of points in general position (Bowyer, Watson 1981). Throws
/// std::runtime_error where rounding spoils the cavity.
TetMesh delaunay(const std::vector<Vec3>& points);

/// Outward triangles that belong to one tetrahedron alone; vertices are those of the mesh.
std::vector<Triangle> boundary(const TetMesh& mesh);

double signed_volume(const TetMesh& mesh, const Tetrahedron& t);

}  // namespace thew::tools
