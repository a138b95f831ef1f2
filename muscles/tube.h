// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/path.h"
#include "rig/mesh.h"

namespace thew::muscles {

/// A closed tube along a path: a pole, `rings` rings of `around` nodes at equal distances, and a
/// pole, with 2 * around * rings triangles. `radius` has keys (share of the path 0..1, radius in
/// m), linear between them.
TriMesh make_tube(const TracedPath& path, int around, int rings,
                  const std::vector<std::array<double, 2>>& radius);

/// Triangles of such a tube. Nodes are ordered first pole, rings, last pole.
std::vector<Triangle> tube_triangles(int around, int rings);

}  // namespace thew::muscles
