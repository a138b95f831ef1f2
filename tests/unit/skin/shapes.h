// SPDX-License-Identifier: Apache-2.0
#pragma once

// Closed shapes for the tests of the skin library.
#include <cmath>
#include <random>

#include "rig/mesh.h"
#include "skin/surface/surface.h"

namespace thew::tests {

/// A mesh with what searches need.
struct Shape {
  TriMesh mesh;
  Surface surface;
  Points x;
  Bvh bvh;
};

inline Shape make_shape(const TriMesh& mesh) {
  Shape shape{mesh,
              make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size())),
              to_points(mesh.vertices),
              {}};
  shape.bvh = build_bvh(shape.surface, shape.x);
  return shape;
}

/// [-h, h]^3.
inline TriMesh cube(double h) {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(i & 1 ? h : -h, i & 2 ? h : -h, i & 4 ? h : -h);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// About the z axis, in n x m quads.
inline TriMesh torus(double major, double minor, int n, int m) {
  TriMesh mesh;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < m; ++k) {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * k / m, r = major + minor * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
      const int a = i * m + k, b = (i + 1) % n * m + k;
      const int c = (i + 1) % n * m + (k + 1) % m, d = i * m + (k + 1) % m;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// A tube along y from `from` to `to`, closed by a pole at either end: first pole, rings, last
/// pole.
template <typename Radius>
TriMesh spindle(double from, double to, int around, int rings, Radius radius) {
  TriMesh mesh;
  mesh.vertices.emplace_back(0, from, 0);
  for (int i = 0; i < rings; ++i) {
    const double y = from + (to - from) * (i + 1) / (rings + 1);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * M_PI * k / around, r = radius(y, angle);
      mesh.vertices.emplace_back(r * std::cos(angle), y, r * std::sin(angle));
    }
  }
  mesh.vertices.emplace_back(0, to, 0);
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around, top = last - around;
    mesh.triangles.push_back({0, 1 + k, 1 + next});
    for (int i = 0; i + 1 < rings; ++i) {
      const int a = 1 + i * around + k, b = 1 + i * around + next;
      mesh.triangles.push_back({a, a + around, b + around});
      mesh.triangles.push_back({a, b + around, b});
    }
    mesh.triangles.push_back({top + k, last, top + next});
  }
  return mesh;
}

inline TriMesh ball(double radius, const Vec3& centre, int around, int rings) {
  // Rings at equal steps of angle, because equal steps of height would leave the poles without
  // nodes.
  TriMesh mesh = spindle(0.0, 1.0, around, rings, [](double, double) { return 1.0; });
  for (Vec3& p : mesh.vertices) {
    const double angle = M_PI * p.y();
    p = centre + radius * Vec3(p.x() * std::sin(angle), -std::cos(angle), p.z() * std::sin(angle));
  }
  return mesh;
}

}  // namespace thew::tests
