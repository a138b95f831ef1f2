// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "tools/lab/elements/delaunay.h"

namespace thew::tools {

/// What each method of others moves: a closed surface alone, or one filled with tetrahedra.
struct RivalBody {
  std::vector<Vec3> rest;               ///< m
  Points x, v;                          ///< m, m/s
  std::vector<double> mass;             ///< kg
  std::vector<Triangle> triangles;      ///< the surface, outward
  std::vector<Tetrahedron> tetrahedra;  ///< none: a surface alone
  std::vector<char> driven, surface;    ///< by node: the surroundings move it; it is of the surface
};
/// At rest, nothing driven. Masses by a third of each triangle's area, or a quarter of each
/// tetrahedron's volume; density in kg/m^3.
RivalBody surface_body(const TriMesh& mesh, double density);
RivalBody solid_body(const TetMesh& mesh, double density);

/// What moves a body: at a time (s), where the driven nodes are, and how deep a point lies in an
/// obstacle (m, along the direction in which that grows; zero outside). Either may be empty.
struct Surroundings {
  std::function<void(double time, const std::vector<Vec3>& rest, Points& x)> drive;
  std::function<Vec3(double time, const Vec3& p)> beyond;
};

/// Advances a body by h seconds to `time`.
using Stepper = std::function<void(const Surroundings&, double time, double h, RivalBody&)>;

/// m^3 within the surface.
double volume_of(const RivalBody& body);

/// Puts driven nodes where the surroundings have them, their velocity by the way that took.
void drive_nodes(const Surroundings& around, double time, double h, RivalBody& body);
/// Puts free nodes of the surface out of the obstacles, whose normal then takes no velocity inward.
void keep_out(const Surroundings& around, double time, RivalBody& body);

/// Linear momentum and that about the origin, kg m/s and kg m^2/s.
struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
Momentum momentum_of(const RivalBody& body);

}  // namespace thew::tools
