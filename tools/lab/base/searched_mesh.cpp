// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/base/searched_mesh.h"

#include <utility>

namespace thew::tools {

SearchedMesh::SearchedMesh(TriMesh m) : mesh(std::move(m)) {
  surface = make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size()));
  x = to_points(mesh.vertices);
  bvh = build_bvh(surface, x);
}

ClosestPoint SearchedMesh::nearest(const Vec3& p, double reach) const {
  return closest_point(surface, bvh, x, p, reach);
}

}  // namespace thew::tools
