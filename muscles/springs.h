// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Material of the surface of a muscle. Stiffness is per width, so that it does not change if the
/// mesh is refined. The defaults were chosen by trial on the arm; the reason for anisotropy and
/// shape is in muscles/notes.md ("Shape").
struct SpringMaterial {
  double stiffness = 1000.0;  ///< membrane stiffness across the fibres, N/m
  double anisotropy = 10.0;   ///< stiffness along the fibres over that across them [1]
  double shear = 0.2;  ///< stiffness of the springs between opposite vertices over `stiffness` [1]
  double bending = 1e-4;  ///< N m, in the same springs
  /// Stiffness against a change of a spring's vector from that of the carried shape, over its
  /// stiffness against a change of length [1]. It stands for the inside of the muscle, which a
  /// surface lacks.
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

/// Springs of a mesh (after Van Gelder 1998). Edges: k = Y(a) A / L^2, with A a third of the area
/// of the two triangles of the edge, L its length, a its angle with the fibres, and Y(a) =
/// stiffness (1
/// + (anisotropy - 1) cos^4 a), where `stiffness` is the mean of its two nodes' if `by_node` (N/m)
/// is not empty, and the material's otherwise. Opposite vertices: k = (shear Y(a) + bending / L^2)
/// A / L^2. The bending part grows as 1/h^2 with the edge length h; because distances change only
/// to second order as a flat plate bends, its energy still falls as h^2 (as h^4 for shear alone).
/// `fibres`: unit direction by vertex, or empty for an isotropic material. Throws Error(kInput) if
/// a spring has length 0.
Springs make_springs(const TriMesh& mesh, const std::vector<Vec3>& fibres,
                     const SpringMaterial& material, const std::vector<double>& by_node = {});

/// Mass (kg) by node: density (kg/m^3) times enclosed volume, distributed by a third of the area of
/// each triangle.
std::vector<double> lumped_masses(const TriMesh& mesh, double density);

/// f += spring forces (N) at positions x with the given rest lengths.
void add_spring_forces(const Springs& springs, const std::vector<double>& rest_length,
                       const Points& x, Points& f);

/// Sets `length` (m) to the length of each spring.
void spring_lengths(const Springs& springs, const Points& x, std::vector<double>& length);

/// Strain of the edges of a body, for the health check.
struct EdgeStrain {
  double energy = 0.0;            ///< J, elastic energy of all edges
  double reference_energy = 0.0;  ///< J, energy of all edges if each had twice its rest length
  int reversed = 0;          ///< number of edges that point against the same edge of the target
  bool within_limit = true;  ///< no edge is longer than its limit
};
/// The strain at x. The limit of an edge is `most` times the larger of its present and its first
/// rest length.
EdgeStrain strain_of_edges(const Springs& springs, const std::vector<double>& rest_length,
                           const Points& x, const Points& target, double most);

/// Elastic energy (J), sum of k (|d| - L)^2 / 2.
double spring_energy(const Springs& springs, const std::vector<double>& rest_length,
                     const Points& x);

/// Upper bound of the highest squared angular frequency (1/s^2) of the free nodes, by Gershgorin:
/// the largest of 2 sum k / m over nodes. An explicit step is stable below 2 / sqrt of it.
double highest_frequency_squared(const Springs& springs, const std::vector<double>& mass,
                                 const std::vector<char>& driven);

}  // namespace thew::muscles
