// SPDX-License-Identifier: Apache-2.0
#include "tools/base/bake_mesh.h"

#include <algorithm>

namespace thew::tools {

const char* kind_name(BakeMesh::Kind kind) {
  static constexpr const char* kNames[] = {"muscle", "bone", "skin", "prop"};
  return kNames[static_cast<int>(kind)];
}

std::array<double, 3> kind_colour(BakeMesh::Kind kind) {
  switch (kind) {
    case BakeMesh::Kind::kMuscle:
      return {0.55, 0.12, 0.10};
    case BakeMesh::Kind::kBone:
      return {0.80, 0.74, 0.62};
    case BakeMesh::Kind::kProp:
      return {0.35, 0.42, 0.50};
    default:
      return {0.78, 0.52, 0.42};
  }
}

std::vector<int> shaded_vertices(const BakeMesh& mesh) {
  constexpr double kEdge = 0.5;  // cosine of 60 degrees, at which an edge is sharp
  const std::vector<int> first = first_at_position(mesh.rest);
  if (mesh.kind != BakeMesh::Kind::kSkin) return first;
  const std::vector<Vec3> normals = vertex_normals(mesh.rest);
  std::vector<std::vector<int>> smooth(first.size());  // by place, of each of its shades the first
  std::vector<int> shaded;
  for (int i = 0; i < static_cast<int>(first.size()); ++i) {
    std::vector<int>& shades = smooth[first[i]];
    const auto at = std::find_if(shades.begin(), shades.end(),
                                 [&](int other) { return normals[i].dot(normals[other]) > kEdge; });
    shaded.push_back(at == shades.end() ? i : *at);
    if (at == shades.end()) shades.push_back(i);
  }
  return shaded;
}

std::vector<Triangle> shaded_triangles(const BakeMesh& mesh) {
  const std::vector<int> shaded = shaded_vertices(mesh);
  std::vector<Triangle> triangles = mesh.rest.triangles;
  for (Triangle& triangle : triangles) {
    for (int& vertex : triangle) vertex = shaded[vertex];
  }
  return triangles;
}

}  // namespace thew::tools
