// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <functional>
#include <limits>
#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// The yardstick: displacement finite elements on tetrahedra of 4 nodes (linear) or 10 (quadratic).
/// Energy of an element: 1/2 z K z + V0 (penalty/2 (J - 1)^2 - pull (J - 1)), J = V / V0 its mean
/// dilatation, so that nearly incompressible quadratic elements do not lock.
///  - linear elasticity with the paper's element-wise volume penalty: z = x - X, K of Lame's two
///    constants, pull 0;
///  - stable neo-Hookean (Smith, de Goes, Kim 2018, without the logarithm): z = x, K = shear
///  grad.grad,
///    pull = shear, penalty = Lame's first constant.
struct FemMaterial {
  bool neo_hookean = false;
  double shear = 1000.0;    ///< Pa
  double lambda = 0.0;      ///< Pa, Lame's first in K; linear elasticity only
  double penalty = 1e4;     ///< Pa
  double density = 1060.0;  ///< kg/m^3
};

/// Corners between which the middles of a quadratic tetrahedron lie, in their order.
inline constexpr int kMiddles[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

struct FemBody {
  int order = 1;  ///< 1: 4 nodes, 2: 10 nodes (corners, then kMiddles)
  std::vector<Vec3> rest, x, v;
  std::vector<int> elements;  ///< 4 or 10 nodes each
  std::vector<char> surface;  ///< by node: planes stop it
  std::vector<char> fixed;    ///< by degree of freedom: it keeps the x it has
  std::vector<Vec3> load;     ///< N, by node; may be empty
  FemMaterial material;

  // From prepare().
  std::vector<double> rest_volume, mass;   ///< by element, m^3; by node, kg
  Eigen::SparseMatrix<double> matrix;      ///< pattern, and room for values
  Eigen::SparseMatrix<double> constant;    ///< K
  std::vector<Eigen::MatrixXd> stiffness;  ///< K by element
  std::vector<int> slot;                   ///< by element and pair of its nodes: place in a column

  int nodes_per_element() const { return order == 1 ? 4 : 10; }
  int count() const { return static_cast<int>(elements.size()) / nodes_per_element(); }
};
/// Fills what follows from rest, elements and material; x = rest, v = 0 where not given.
void prepare(FemBody& body);
/// Adds an element's block to the values of a matrix of body.matrix's pattern.
void add_block(const FemBody& body, int element, const Eigen::MatrixXd& k, double* values);

struct FemStep {
  double h = 0.0;                                         ///< s, implicit Euler; 0: quasi-static
  double damping = 0.0;                                   ///< 1/s
  double low = -std::numeric_limits<double>::infinity();  ///< m, planes across y
  double high = std::numeric_limits<double>::infinity();
  /// m, where the planes end along x, in an edge rounded by `rounding` away from the body
  double edge = std::numeric_limits<double>::infinity(), rounding = 0.0;
  /// In place of the planes: how deep a point is in an obstacle, m, along the direction in which
  /// that grows; zero outside.
  std::function<Vec3(const Vec3&)> obstacle = {};
  double firmness = 1e5;    ///< N/m of planes or obstacle at a node
  bool direct = false;      ///< Cholesky, else conjugate gradients
  double residual = 1e-6;   ///< that those leave, of the right side
  int iterations = 10;      ///< of Newton, at most
  double tolerance = 1e-6;  ///< m, of the last correction
};
struct FemResult {
  int iterations = 0, inverted = 0;  ///< elements with J <= 0
  double correction = 0.0;           ///< m, the last
  double penetration = 0.0;          ///< m, of the planes
  bool converged = false;
};
FemResult solve_step(FemBody& body, const FemStep& step);

/// m^3 of all elements.
double fem_volume(const FemBody& body);

}  // namespace thew::tools
