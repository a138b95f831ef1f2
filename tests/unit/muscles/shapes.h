// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes for the tests of the muscles library.
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "rig/mesh.h"

namespace thew::tests {

using rig::dot;
inline double dot(const Points& a, const Points& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.size(); ++i) sum += to_vec(a[i]).dot(to_vec(b[i]));
  return sum;
}

/// The unit cube from the origin, outward.
inline TriMesh unit_cube() {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Each triangle becomes four alike.
inline TriMesh subdivided(const TriMesh& mesh) {
  TriMesh fine;
  fine.vertices = mesh.vertices;
  std::map<std::array<int, 2>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                     static_cast<int>(fine.vertices.size()));
    if (is_new) fine.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
    return entry->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.insert(fine.triangles.end(),
                          {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return fine;
}

/// A muscle-like tube along y, thickest in the middle: pole, rings of `around` nodes, pole.
inline TriMesh spindle(int around = 16, int rings = 15, double length = 0.15,
                       double radius = 0.02) {
  TriMesh mesh;
  mesh.vertices.emplace_back(0, 0, 0);
  for (int i = 1; i <= rings; ++i) {
    const double u = static_cast<double>(i) / (rings + 1), r = radius * std::sqrt(4 * u * (1 - u));
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * M_PI * k / around;
      mesh.vertices.emplace_back(r * std::cos(angle), u * length, r * std::sin(angle));
    }
  }
  mesh.vertices.emplace_back(0, length, 0);
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

/// A flat sheet in the plane z = 0 of n x m squares of side h; node (i, k) is i (m + 1) + k at
/// (i h, k h, 0).
inline TriMesh sheet(int n, int m, double h) {
  TriMesh mesh;
  for (int i = 0; i <= n; ++i) {
    for (int k = 0; k <= m; ++k) mesh.vertices.emplace_back(i * h, k * h, 0.0);
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < m; ++k) {
      const int a = i * (m + 1) + k, b = a + m + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return mesh;
}

/// Points of numbers in -size..size.
inline Points noise(size_t count, double size, unsigned seed) {
  std::mt19937 engine(seed);
  const auto next = [&] { return size * (engine() / 2147483647.5 - 1.0); };
  Points rows;
  for (size_t i = 0; i < count; ++i) {
    const double x = next(), y = next(), z = next();
    rows.push_back(Point{x, y, z, 0.0});
  }
  return rows;
}

inline Points moved(const Points& x, double s, const Points& d) {
  Points out(x);
  for (size_t i = 0; i < x.size(); ++i) out[i] += s * d[i];
  return out;
}

}  // namespace thew::tests
