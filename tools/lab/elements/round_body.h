// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <vector>

#include "tools/lab/elements/fem.h"

namespace thew::tools {

/// A neo-Hookean body of revolution about z, of quadratic triangles of its half section r >= 0: the
/// energy of fem.h's elements, each with one mean dilatation, so that a section refined far beyond
/// what tetrahedra allow is what bodies that are round are measured against.
struct RoundBody {
  using Place = std::array<double, 2>;  ///< r, z, m
  std::vector<Place> rest, x;
  std::vector<std::array<int, 6>> elements;  ///< corners, then the middles of 01, 12, 20
  std::vector<std::array<char, 2>> fixed;    ///< by node, r and z: it keeps the x it has
  std::vector<int> rim;                      ///< corner, middle, corner ... along the free surface
  double shear = 1000.0, penalty = 1e6;      ///< Pa

  // From prepare().
  std::vector<double> rest_volume;      ///< m^3, of each ring
  std::vector<double> rim_area;         ///< m^2, by place on the rim
  Eigen::SparseMatrix<double> elastic;  ///< shear's part of the Hessian, constant, N/m
};
void prepare(RoundBody& body);

/// A quarter of an ellipse's section (r, z >= 0), n^2 triangles: half axes across and along, m.
RoundBody round_ellipsoid(double across, double along, int n);
/// The same cut off at z = held, where both are fixed: 2 n m triangles, m along z.
RoundBody round_spindle(double across, double along, double held, int n, int m);

/// Brings it to rest by Newton with line search. `beyond`: how deep a place of the rim is in an
/// obstacle, m, along the direction in which that grows; may be empty. False: not converged.
bool rest_round(const std::function<RoundBody::Place(const RoundBody::Place&)>& beyond,
                double tolerance, RoundBody& body);

double volume_of(const RoundBody& body);  ///< m^3, of the half that is meshed
/// The free surface as a line of `parts` pieces a quadratic edge.
std::vector<RoundBody::Place> rim_line(const RoundBody& body, int parts);

}  // namespace thew::tools
