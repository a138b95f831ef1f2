// SPDX-License-Identifier: Apache-2.0
#include "muscles/tube.h"

#include "muscles/weights.h"
#include "rig/math.h"

namespace thew::muscles {

std::vector<Triangle> tube_triangles(int around, int rings) {
  std::vector<Triangle> triangles;
  const auto node = [&](int ring, int k) { return 1 + ring * around + (k + around) % around; };
  const int last = 1 + rings * around;
  for (int k = 0; k < around; ++k) triangles.push_back({0, node(0, k + 1), node(0, k)});
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < around; ++k) {
      const int a = node(ring, k), b = node(ring, k + 1);
      const int c = node(ring + 1, k), d = node(ring + 1, k + 1);
      if ((ring + k) % 2 == 0) {  // alternate diagonals, so that the mesh has no sense of twist
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
      } else {
        triangles.push_back({a, b, c});
        triangles.push_back({b, d, c});
      }
    }
  }
  for (int k = 0; k < around; ++k) {
    triangles.push_back({last, node(rings - 1, k), node(rings - 1, k + 1)});
  }
  return triangles;
}

TriMesh make_tube(const TracedPath& path, int around, int rings,
                  const std::vector<std::array<double, 2>>& radius) {
  WeightProfile profile;
  profile.keys = radius;
  std::vector<double> s(path.points.size(), 0.0);
  for (size_t i = 1; i < s.size(); ++i) {
    s[i] = s[i - 1] + (path.points[i] - path.points[i - 1]).norm();
  }
  TriMesh mesh;
  mesh.triangles = tube_triangles(around, rings);
  mesh.vertices.push_back(path.points.front());
  Vec3 normal = (path.points[1] - path.points[0]).unitOrthogonal();
  for (int ring = 0; ring < rings; ++ring) {
    const double u = (ring + 0.5) / rings;
    size_t k = 1;
    while (k + 1 < s.size() && s[k] < u * s.back()) ++k;
    const Vec3 step = path.points[k] - path.points[k - 1];
    const Vec3 centre = path.points[k - 1] + (u * s.back() - s[k - 1]) / (s[k] - s[k - 1]) * step;
    const Vec3 tangent = step.normalized();
    normal = (normal - normal.dot(tangent) * tangent).normalized();
    const Vec3 side = tangent.cross(normal);
    for (int j = 0; j < around; ++j) {
      const SinCos turn = sin_cos(2.0 * kPi * j / around);
      mesh.vertices.push_back(centre +
                              profile_weight(profile, u) * (turn.cos * normal + turn.sin * side));
    }
  }
  mesh.vertices.push_back(path.points.back());
  return mesh;
}

}  // namespace thew::muscles
