// SPDX-License-Identifier: Apache-2.0
#include "muscles/springs.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "muscles/lanes.h"
#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

// An edge of one triangle.
struct Side {
  std::array<int, 2> edge;  // smaller index first
  int opposite;
  double area;  // m^2, of the triangle
  bool operator<(const Side& o) const {
    return edge != o.edge ? edge < o.edge : opposite < o.opposite;
  }
};

double triangle_area(const TriMesh& mesh, const Triangle& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
}

std::vector<Side> sorted_sides(const TriMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const double area = triangle_area(mesh, t);
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      sides.push_back({{std::min(a, b), std::max(a, b)}, t[(k + 2) % 3], area});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

// cos^2 of the angle between the spring and the fibres, mean of both ends.
double fibre_share(const std::vector<Vec3>& fibres, int a, int b, const Vec3& along) {
  if (fibres.empty()) return 0.0;
  const double at_a = along.dot(fibres[a]), at_b = along.dot(fibres[b]);
  return 0.5 * (at_a * at_a + at_b * at_b) / along.squaredNorm();
}

struct SpringAdder {
  const TriMesh& mesh;
  const std::vector<Vec3>& fibres;
  const SpringMaterial& material;
  const std::vector<double>& by_node;
  Springs& springs;

  // Adds a spring of stiffness k = (share Y(a) + bending / L^2) A / L^2.
  void add(int a, int b, double area, double share, double bending) const {
    const Vec3 along = mesh.vertices[b] - mesh.vertices[a];
    const double length2 = along.squaredNorm();
    if (length2 == 0.0) {
      throw Error(ErrorCode::kInput, "mesh: nodes " + std::to_string(a) + " and " +
                                         std::to_string(b) +
                                         " of one spring are in the same place; weld the mesh");
    }
    const double fibre = fibre_share(fibres, a, b, along);
    const double across = by_node.empty() ? material.stiffness : 0.5 * (by_node[a] + by_node[b]);
    const double Y = across * (1.0 + (material.anisotropy - 1.0) * fibre * fibre);
    springs.nodes.push_back({a, b});
    springs.stiffness.push_back((share * Y + bending / length2) * area / length2);
    springs.rest_length.push_back(std::sqrt(length2));
    springs.fibre_share.push_back(fibre);
  }
};

[[gnu::always_inline]] inline double squared(Point d) {
  const Point p = d * d;
  return (p[0] + p[1]) + p[2];
}

}  // namespace

Springs make_springs(const TriMesh& mesh, const std::vector<Vec3>& fibres,
                     const SpringMaterial& material, const std::vector<double>& by_node) {
  const std::vector<Side> sides = sorted_sides(mesh);
  Springs springs;
  const SpringAdder adder{mesh, fibres, material, by_node, springs};
  for (bool structural : {true, false}) {
    for (size_t i = 0; i < sides.size();) {
      size_t end = i + 1;
      while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
      const bool paired = end == i + 2;
      const double area = (sides[i].area + (paired ? sides[i + 1].area : 0.0)) / 3.0;
      const int c = sides[i].opposite, d = paired ? sides[i + 1].opposite : c;
      if (structural) {
        adder.add(sides[i].edge[0], sides[i].edge[1], area, 1.0, 0.0);
      } else if (c != d) {
        adder.add(c, d, area, material.shear, material.bending);
      }
      i = end;
    }
    if (structural) springs.structural = static_cast<int>(springs.nodes.size());
  }
  return springs;
}

std::vector<double> lumped_masses(const TriMesh& mesh, double density) {
  std::vector<double> mass(mesh.vertices.size(), 0.0);
  double total = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const double area = triangle_area(mesh, t);
    total += area;
    for (int i : t) mass[i] += area / 3.0;
  }
  const double per_area = density * enclosed_volume(mesh) / total;  // kg/m^2
  for (double& m : mass) m *= per_area;
  return mass;
}

THEW_VECTORISED
void add_spring_forces(const Springs& springs, const std::vector<double>& rest_length,
                       const Points& x, Points& f) {
  const size_t count = springs.nodes.size();
  for (size_t i = 0; i < count; ++i) {
    const auto [a, b] = springs.nodes[i];
    const Point d = x[b] - x[a];
    const double length = std::sqrt(squared(d));
    // Two nodes at one position have no direction, so there is no force.
    const double tension =
        length > 0.0 ? springs.stiffness[i] * (length - rest_length[i]) / length : 0.0;
    f[a] += tension * d;
    f[b] -= tension * d;
  }
}

namespace {

// x_a - x_b of the four springs from `first` on. Lanes beyond `count` repeat the last spring.
[[gnu::always_inline]] inline Lanes3 differences_of(const Springs& springs, const Points& x,
                                                    size_t first, size_t count) {
  const auto d = [&](size_t k) {
    const auto& [a, b] = springs.nodes[std::min(k, count - 1)];
    return x[a] - x[b];
  };
  return side_by_side(d(first), d(first + 1), d(first + 2), d(first + 3));
}

[[gnu::always_inline]] inline Lanes four_of(const std::vector<double>& values, size_t first,
                                            size_t count) {
  Lanes four;
  for (size_t l = 0; l < kLanes; ++l) four[l] = values[std::min(first + l, count - 1)];
  return four;
}

}  // namespace

THEW_VECTORISED
void spring_lengths(const Springs& springs, const Points& x, std::vector<double>& length) {
  const size_t count = springs.nodes.size();
  length.resize(count);
  for (size_t first = 0; first < count; first += kLanes) {
    const Lanes3 d = differences_of(springs, x, first, count);
    const Lanes four = root(dot(d, d));
    for (size_t l = 0; l < kLanes && first + l < count; ++l) length[first + l] = four[l];
  }
}

THEW_VECTORISED
EdgeStrain strain_of_edges(const Springs& springs, const std::vector<double>& rest_length,
                           const Points& x, const Points& target, double most) {
  const size_t count = springs.structural;
  Lanes energy = {}, reference = {};
  auto within = energy == energy;  // by lane: -1 for true, 0 for false
  auto reversed = within - within;
  for (size_t first = 0; first < count; first += kLanes) {
    const Lanes index = Lanes{0, 1, 2, 3} + static_cast<double>(first);
    const auto there = index < static_cast<double>(count);
    const Lanes stiffness = there ? 0.5 * four_of(springs.stiffness, first, count) : Lanes{};
    const Lanes now = four_of(rest_length, first, count);
    const Lanes before = four_of(springs.rest_length, first, count);
    const Lanes3 d = differences_of(springs, x, first, count);
    const Lanes length = root(dot(d, d)), stretch = length - now;
    within &= length <= most * (now > before ? now : before);
    reversed -= there & (dot(d, differences_of(springs, target, first, count)) < 0.0);
    energy += stiffness * stretch * stretch;
    reference += stiffness * before * before;
  }
  const auto sum = [](const auto& a) { return (a[0] + a[1]) + (a[2] + a[3]); };
  return {sum(energy), sum(reference), static_cast<int>(sum(reversed)), sum(within) == -kLanes};
}

double spring_energy(const Springs& springs, const std::vector<double>& rest_length,
                     const Points& x) {
  double energy = 0.0;  // sum of k (l - l0)^2 / 2
  for (size_t i = 0; i < springs.nodes.size(); ++i) {
    const auto [a, b] = springs.nodes[i];
    const double extension = std::sqrt(squared(x[b] - x[a])) - rest_length[i];
    energy += 0.5 * springs.stiffness[i] * extension * extension;
  }
  return energy;
}

double highest_frequency_squared(const Springs& springs, const std::vector<double>& mass,
                                 const std::vector<char>& driven) {
  std::vector<double> stiffness(mass.size(), 0.0);
  for (size_t i = 0; i < springs.nodes.size(); ++i) {
    for (int node : springs.nodes[i]) stiffness[node] += springs.stiffness[i];
  }
  double highest = 0.0;
  for (size_t i = 0; i < mass.size(); ++i) {
    if (!driven[i]) highest = std::max(highest, 2.0 * stiffness[i] / mass[i]);
  }
  return highest;
}

}  // namespace thew::muscles
