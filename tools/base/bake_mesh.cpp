// SPDX-License-Identifier: Apache-2.0
#include "tools/base/bake_mesh.h"

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

std::vector<Triangle> shaded_triangles(const BakeMesh& mesh) {
  return mesh.kind == BakeMesh::Kind::kSkin ? mesh.rest.triangles : joined_triangles(mesh.rest);
}

}  // namespace thew::tools
