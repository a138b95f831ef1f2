// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/elements/fem_ball.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace thew::tools {
namespace {

// A lattice in general position: moved a little, always the same way.
double jitter(unsigned k) {
  k *= 2654435761u;
  k ^= k >> 15;
  k *= 2246822519u;
  k ^= k >> 13;
  return (k & 0xffffu) / 65536.0 - 0.5;
}

std::vector<Vec3> lattice_points(double spacing, double radius) {
  std::vector<Vec3> points;
  const int reach = static_cast<int>(std::ceil(radius / spacing)) + 1;
  unsigned id = 0;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        for (double half : {0.0, 0.5}) {
          const Vec3 moved(jitter(3 * id), jitter(3 * id + 1), jitter(3 * id + 2));
          const Vec3 p = spacing * (Vec3(x, y, z) + Vec3::Constant(half) + 0.02 * moved);
          if (p.norm() < radius) points.push_back(p);
          ++id;
        }
      }
    }
  }
  return points;
}

TetMesh fill(const TriMesh& surface, double radius, double spacing, double edge) {
  // Inside first: points of one sphere alone have no tetrahedra in general position.
  std::vector<Vec3> points = lattice_points(spacing, 1.0 - 0.7 * edge);
  const int inner = static_cast<int>(points.size()), outer = surface.vertices.size();
  for (const Vec3& p : surface.vertices) points.push_back(p / radius);
  TetMesh mesh = delaunay(points);
  std::rotate(mesh.vertices.begin(), mesh.vertices.begin() + inner, mesh.vertices.end());
  for (Vec3& p : mesh.vertices) p *= radius;
  std::copy(surface.vertices.begin(), surface.vertices.end(), mesh.vertices.begin());
  for (Tetrahedron& t : mesh.tetrahedra) {
    for (int& corner : t) corner = corner < inner ? corner + outer : corner - inner;
  }
  return mesh;
}

std::set<Triangle> face_set(const std::vector<Triangle>& triangles) {
  std::set<Triangle> out;
  for (Triangle t : triangles) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    out.insert(t);
  }
  return out;
}

}  // namespace

TetMesh fill_ball(const TriMesh& surface, int tetrahedra) {
  double radius = 0.0;
  for (const Vec3& p : surface.vertices) radius = std::max(radius, p.norm());
  const double faces = static_cast<double>(surface.triangles.size());
  const double edge = std::sqrt(4.0 * 3.14159265 / faces * 4.0 / std::sqrt(3.0));
  // A body-centred lattice has two points a cell; an inner point brings about 6.5 tetrahedra.
  const double inner = std::max((tetrahedra - faces) / 6.5, 1.0);
  double spacing = std::cbrt(2.0 * 4.19 * std::pow(1.0 - 0.7 * edge, 3) / inner);
  TetMesh best;
  for (int i = 0; i < 12; ++i) {
    TetMesh mesh = fill(surface, radius, spacing, edge);
    const double found = static_cast<double>(mesh.tetrahedra.size());
    const auto off = [&](const TetMesh& m) {
      return std::abs(static_cast<double>(m.tetrahedra.size()) - tetrahedra);
    };
    if (best.tetrahedra.empty() || off(mesh) < off(best)) best = mesh;
    if (off(best) < 0.012 * tetrahedra) break;
    // First by the ratio of inner points, then a little to either side.
    spacing *= i == 0 ? std::cbrt((found - faces) / std::max(tetrahedra - faces, 1.0))
                      : 1.0 + 0.008 * i * (i % 2 ? 1 : -1);
  }
  if (face_set(boundary(best)) != face_set(surface.triangles)) {
    throw Error(ErrorCode::kInput, "the ball's surface is not the hull of its vertices");
  }
  return best;
}

FemBody linear_ball(const TriMesh& surface, int tetrahedra, const FemMaterial& material) {
  const TetMesh mesh = fill_ball(surface, tetrahedra);
  FemBody body;
  body.material = material;
  body.rest = mesh.vertices;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    body.elements.insert(body.elements.end(), t.begin(), t.end());
  }
  body.surface.assign(body.rest.size(), 0);
  std::fill_n(body.surface.begin(), surface.vertices.size(), 1);
  prepare(body);
  return body;
}

namespace {

// The quadratic tetrahedron of four points of a lattice (even, so that their middles are of it
// too), turned outward.
void add_element(std::array<LatticePoint, 4> c, const NodeOfLattice& node, FemBody& body) {
  const auto side = [&](int k) {
    return Vec3(c[k][0] - c[0][0], c[k][1] - c[0][1], c[k][2] - c[0][2]);
  };
  if (side(1).cross(side(2)).dot(side(3)) < 0.0) std::swap(c[2], c[3]);
  for (const auto& corner : c) body.elements.push_back(node(corner));
  for (const auto& [a, b] : kMiddles) {
    LatticePoint middle;
    for (int k = 0; k < 3; ++k) middle[k] = (c[a][k] + c[b][k]) / 2;
    body.elements.push_back(node(middle));
  }
}

}  // namespace

void add_kuhn_cell(const LatticePoint& cell,
                   const std::function<LatticePoint(const LatticePoint&)>& place,
                   const NodeOfLattice& node, FemBody& body) {
  for (const auto& order : kKuhnOrders) {
    std::array<LatticePoint, 4> corners;
    LatticePoint at = cell;
    bool inside = true;
    for (int k = 0; k < 4; ++k) {
      if (k > 0) ++at[order[k - 1]];
      corners[k] = place(at);
      for (const int coordinate : corners[k]) inside = inside && coordinate >= 0;
    }
    if (inside) add_element(corners, node, body);
  }
}

FemResult close_planes(double from, double to, int steps, FemStep step, FemBody& body) {
  step.direct = true;
  step.iterations = 60;
  step.tolerance = 1e-6 * from;
  step.firmness = 300.0 * body.material.shear * from;
  FemResult result;
  for (int i = 1; i <= steps; ++i) {
    step.high = from + (to - from) * i / steps;
    result = solve_step(body, step);
    if (!result.converged) break;
  }
  return result;
}

FemBody octant_ball(double radius, int n, const FemMaterial& material) {
  // The tetrahedron i + j + k <= 2n of lattice points, twice as fine as the elements; a point at
  // distance s in the sum norm goes to distance s in the Euclidean.
  FemBody body;
  body.order = 2;
  body.material = material;
  std::map<LatticePoint, int> index;
  const auto node = [&](const LatticePoint& at) {
    const auto [found, added] = index.try_emplace(at, static_cast<int>(body.rest.size()));
    if (added) {
      const Vec3 p(at[0], at[1], at[2]);
      const double sum = p.sum(), length = p.norm();
      body.rest.push_back(length > 0.0 ? Vec3(radius * sum / (2.0 * n * length) * p) : p);
      body.surface.push_back(at[0] + at[1] + at[2] == 2 * n);
      for (int k = 0; k < 3; ++k) body.fixed.push_back(at[k] == 0);
    }
    return found->second;
  };
  // Of the lattice of partial sums u >= v >= w: each element lies within the octant.
  const auto place = [](const LatticePoint& sums) {
    return LatticePoint{2 * (sums[0] - sums[1]), 2 * (sums[1] - sums[2]), 2 * sums[2]};
  };
  for (int u = 0; u < n; ++u) {
    for (int v = 0; v <= u; ++v) {
      for (int w = 0; w <= v; ++w) {
        add_kuhn_cell({u, v, w}, place, node, body);
      }
    }
  }
  prepare(body);
  return body;
}

TriMesh octant_surface(const FemBody& body) {
  // Faces opposite each corner: three corners and the middles between them.
  constexpr int kFaces[4][6] = {
      {1, 2, 3, 7, 9, 8}, {0, 3, 2, 6, 9, 5}, {0, 1, 3, 4, 8, 6}, {0, 2, 1, 5, 7, 4}};
  TriMesh mesh{body.x, {}};
  for (int e = 0; e < body.count(); ++e) {
    for (const auto& f : kFaces) {
      int n[6];
      bool outside = true;
      for (int k = 0; k < 6; ++k) {
        n[k] = body.elements[10 * e + f[k]];
        outside = outside && body.surface[n[k]];
      }
      if (!outside) continue;
      for (const Triangle& t : {Triangle{n[0], n[3], n[5]},
                                {n[3], n[1], n[4]},
                                {n[5], n[4], n[2]},
                                {n[3], n[4], n[5]}}) {
        mesh.triangles.push_back(t);
      }
    }
  }
  return mesh;
}

}  // namespace thew::tools
