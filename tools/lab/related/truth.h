// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "rig/mesh.h"
#include "tools/lab/elements/round_body.h"

namespace thew::tools {

/// Incompressible neo-Hookean bodies brought to rest: what every method's shape is measured
/// against. Quadratic elements on meshes each twice as fine as the one before, so that the order of
/// convergence is found and the limit by Richardson's extrapolation. Bodies that are round are
/// meshed in their section alone, and so far more finely.
struct Truth {
  std::vector<RoundBody::Place> profile;  ///< of the limit: distance from the axis, and along it
  int axis = 1;                           ///< of that
  TriMesh surface;            ///< of the limit where it is not round, each face in many triangles
  std::vector<int> elements;  ///< by mesh
  std::vector<double> apart;  ///< mean distance of a mesh's surface nodes from the next mesh's, m
  double order = 1.0;         ///< of convergence; 1 where two meshes do not tell
  double error = 0.0;  ///< m, mean distance of the finest mesh's surface nodes from the limit
  double volume_error = 0.0;  ///< of the finest mesh
  bool converged = true;
  bool is_known() const { return !elements.empty(); }
};

/// How a body of n elements a side comes to rest: driven nodes and obstacles at a share 0..1. It is
/// round, or else it is not.
struct TruthScene {
  std::function<RoundBody(int n)> round;
  std::function<void(double share, RoundBody& body)> drive_round;
  int axis = 1;  ///< of a round body: 0 x, 1 y
  std::function<FemBody(int n)> body;
  std::function<void(double share, FemBody& body)> drive;
  std::function<Vec3(double share, const Vec3& p)> beyond;  ///< may be empty, as may both drives
  int coarsest = 2, meshes = 3, steps = 16;                 ///< no meshes: none is asked for
};
Truth find_truth(const TruthScene& scene);

/// Mean distance (m) of points to its surface.
double mean_distance(const std::vector<Vec3>& points, const Truth& truth);

}  // namespace thew::tools
