// SPDX-License-Identifier: Apache-2.0
#include "tools/base/bake_mesh.h"

namespace thew::tools {

const char* kind_name(BakeMesh::Kind kind) {
  static constexpr const char* kNames[] = {"muscle", "bone", "skin"};
  return kNames[static_cast<int>(kind)];
}

std::vector<Triangle> shaded_triangles(const BakeMesh& mesh) {
  return mesh.kind == BakeMesh::Kind::kSkin ? mesh.rest.triangles : joined_triangles(mesh.rest);
}

}  // namespace thew::tools
