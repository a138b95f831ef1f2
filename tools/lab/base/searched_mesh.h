// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/mesh.h"
#include "skin/surface/surface.h"

namespace thew::tools {

/// A mesh and its tree, to find its nearest point of others.
struct SearchedMesh {
  TriMesh mesh;
  Surface surface;
  Points x;
  Bvh bvh;

  explicit SearchedMesh(TriMesh m);
  /// No triangle where there is none within `reach` (m).
  ClosestPoint nearest(const Vec3& p, double reach) const;
};

}  // namespace thew::tools
