// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "rig/mesh.h"

namespace thew::tests {

/// The unit cube at the origin, outward: vertex i has the bits of i as (x, y, z).
inline TriMesh unit_cube() {
  TriMesh cube;
  for (int i = 0; i < 8; ++i) cube.vertices.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return cube;
}

/// A capped cylinder along y of radius 0.1 and height 0.5, each triangle with corners of its own,
/// as importers deliver it.
inline TriMesh split_cylinder(int sides) {
  const auto ring = [&](int i, double y) {
    const double angle = 2.0 * M_PI * (i % sides) / sides;
    return Vec3(0.1 * std::cos(angle), y, 0.1 * std::sin(angle));
  };
  TriMesh mesh;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const int n = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({n, n + 1, n + 2});
  };
  for (int i = 0; i < sides; ++i) {
    add(ring(i, 0.0), ring(i, 0.5), ring(i + 1, 0.5));
    add(ring(i, 0.0), ring(i + 1, 0.5), ring(i + 1, 0.0));
    add({0, 0, 0}, ring(i, 0.0), ring(i + 1, 0.0));
    add({0, 0.5, 0}, ring(i + 1, 0.5), ring(i, 0.5));
  }
  return mesh;
}

}  // namespace thew::tests
