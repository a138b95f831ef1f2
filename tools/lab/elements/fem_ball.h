// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "tools/lab/elements/delaunay.h"
#include "tools/lab/elements/fem.h"

namespace thew::tools {

/// Tetrahedra between a ball's surface (its centre at the origin) and points of a body-centred
/// cubic lattice inside, as near to `tetrahedra` as a lattice comes. The first vertices are the
/// surface's and the boundary is its triangles. Error(kInput) where they are not.
TetMesh fill_ball(const TriMesh& surface, int tetrahedra);

/// Linear elasticity with the paper's penalty on such a filling.
FemBody linear_ball(const TriMesh& surface, int tetrahedra, const FemMaterial& material);

/// Kuhn's six tetrahedra of a cube: the order of its axes along which each goes to the far corner.
inline constexpr int kKuhnOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                          {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
/// Adds the quadratic tetrahedron of four points of a lattice (even, so that their middles are of
/// it too), turned outward; `node` numbers a point.
void add_element(std::array<std::array<int, 3>, 4> corners,
                 const std::function<int(const std::array<int, 3>&)>& node, FemBody& body);

/// One eighth of a ball (x, y, z >= 0) of quadratic curved tetrahedra, n^3 of them, its three
/// planes of symmetry fixed. Neo-Hookean.
FemBody octant_ball(double radius, int n, const FemMaterial& material);

/// Brings the octant quasi-statically between planes at +-`height` (m) in `steps`. The result of
/// the last step that converged.
FemResult squeeze_octant(FemBody& body, double radius, double height, int steps);

/// Triangles of the curved faces of the octant, each of a quadratic face split in four.
TriMesh octant_surface(const FemBody& body);

}  // namespace thew::tools
