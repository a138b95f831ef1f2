// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/math.h"
#include "sim/cache/cache.h"

namespace thew::tests {

// A ball of `around` by `rings` nodes and two poles; `stretch` along y makes it a spindle.
inline BakeMesh ball(const char* name, BakeMesh::Kind kind, const Vec3& centre, double radius,
                     double stretch = 1.0, int around = 24, int rings = 15) {
  BakeMesh mesh;
  mesh.name = name;
  mesh.kind = kind;
  const auto add = [&](double down, double angle) {
    const SinCos v = sin_cos(down * kPi), h = sin_cos(angle);
    mesh.rest.vertices.push_back(centre +
                                 radius * Vec3(v.sin * h.cos, stretch * v.cos, v.sin * h.sin));
    if (kind != BakeMesh::Kind::kMuscle) return;
    mesh.coordinates.push_back({down, angle, down > 0.2 && down < 0.8 ? 1.0 : 0.0});
    mesh.weights.push_back(1.0);
  };
  add(0.0, 0.0);
  for (int k = 1; k <= rings; ++k) {
    for (int i = 0; i < around; ++i) add(double(k) / (rings + 1), 2.0 * kPi * i / around);
  }
  add(1.0, 0.0);
  const int last = 1 + rings * around;
  const auto id = [&](int k, int i) { return 1 + k * around + i % around; };
  for (int i = 0; i < around; ++i) {
    mesh.rest.triangles.push_back({0, id(0, i + 1), id(0, i)});
    for (int k = 0; k + 1 < rings; ++k) {
      mesh.rest.triangles.push_back({id(k, i), id(k, i + 1), id(k + 1, i)});
      mesh.rest.triangles.push_back({id(k, i + 1), id(k + 1, i + 1), id(k + 1, i)});
    }
    mesh.rest.triangles.push_back({last, id(rings - 1, i), id(rings - 1, i + 1)});
  }
  return mesh;
}

}  // namespace thew::tests
