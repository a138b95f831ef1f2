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
using LatticePoint = std::array<int, 3>;
using NodeOfLattice = std::function<int(const LatticePoint&)>;  ///< numbers a point
/// Adds Kuhn's quadratic tetrahedra of a cell: `place` takes their corners to points of a lattice,
/// even ones, so that the middles between them are of it too. Those with a corner below zero are
/// left out.
void add_kuhn_cell(const LatticePoint& cell,
                   const std::function<LatticePoint(const LatticePoint&)>& place,
                   const NodeOfLattice& node, FemBody& body);

/// One eighth of a ball (x, y, z >= 0) of quadratic curved tetrahedra, n^3 of them, its three
/// planes of symmetry fixed. Neo-Hookean.
FemBody octant_ball(double radius, int n, const FemMaterial& material);

/// Brings the planes quasi-statically from y = `from` to `to` (m) in `steps`, with the edge that
/// `step` gives them. The result of the last step that converged, or of the one that did not.
FemResult close_planes(double from, double to, int steps, FemStep step, FemBody& body);

/// Triangles of the curved faces of the octant, each of a quadratic face split in four.
TriMesh octant_surface(const FemBody& body);

}  // namespace thew::tools
