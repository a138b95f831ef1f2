// SPDX-License-Identifier: Apache-2.0
#include "tools/base/seams.h"

namespace thew::tools {

std::vector<Triangle> shaded_triangles(const BakeMesh& mesh) {
  return mesh.kind == BakeMesh::Kind::kSkin ? mesh.rest.triangles : joined_triangles(mesh.rest);
}

}  // namespace thew::tools
