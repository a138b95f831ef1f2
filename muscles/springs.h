// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Material of a muscle's surface, per width, so that refining the mesh leaves it as it was.
struct SpringMaterial {
  double young = 1000.0;     ///< membrane stiffness across the fibres, N/m
  double anisotropy = 10.0;  ///< stiffness along the fibres over across
  double shear = 0.2;        ///< share of `young` in the springs between opposite vertices
  double bending = 1e-4;     ///< N m, in the same springs
  /// Stiffness against leaving the carried shape's edge vectors, over that against leaving their
  /// lengths: stands for the inside of the muscle, which a surface lacks.
  double shape = 2.0;
  double density = 1060.0;  ///< kg/m^3
};

/// Structural springs (edges) first, then shear and bending springs (vertices opposite each edge).
struct Springs {
  std::vector<std::array<int, 2>> nodes;
  std::vector<double> stiffness;    ///< N/m
  std::vector<double> rest_length;  ///< m
  std::vector<double> fibre_share;  ///< cos^2 of the angle to the fibres, at rest
  int structural = 0;               ///< number of edges
};

/// k = Y(a) A / L^2, A a third of the two triangles' area, a the angle between edge and fibre,
/// Y = young (1 + (anisotropy - 1) cos^4 a); opposite vertices: k = (shear Y + bending / L^2) A /
/// L^2, growing as 1/h^2 under refinement. A distance cannot feel the bending of a flat plate to
/// first order: its energy still falls as h^2 (as h^4 for shear alone). `fibres`: unit direction
/// per vertex, or empty for an isotropic material.
Springs make_springs(const TriMesh& mesh, const std::vector<Vec3>& fibres,
                     const SpringMaterial& material);

/// Mass (kg) per node: density * enclosed volume, spread by a third of each triangle's area.
std::vector<double> lumped_masses(const TriMesh& mesh, double density);

/// f += spring forces (N) at positions x with the given rest lengths.
void add_spring_forces(const Springs& springs, const std::vector<double>& rest_length,
                       const Points& x, Points& f);

/// m, by spring.
void spring_lengths(const Springs& springs, const Points& x, std::vector<double>& length);

/// What the edges tell of a body's health.
struct EdgeStrain {
  double energy = 0.0;  ///< J, of all
  double usual = 0.0;   ///< J, at twice their length at rest
  int reversed = 0;     ///< against the target's
  bool within = true;   ///< none is longer than it may be
};
/// At x, `most`: the length that an edge may have over its rest length, now or at first.
EdgeStrain strain_of_edges(const Springs& springs, const std::vector<double>& rest_length,
                           const Points& x, const Points& target, double most);

/// Elastic energy (J).
double spring_energy(const Springs& springs, const std::vector<double>& rest_length,
                     const Points& x);

/// Upper bound of the highest angular frequency squared (1/s^2) over free nodes, by Gershgorin:
/// max over nodes of 2 * sum k / m. An explicit step is stable below 2 / sqrt of it.
double highest_frequency_squared(const Springs& springs, const std::vector<double>& mass,
                                 const std::vector<char>& driven);

}  // namespace thew::muscles
