// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/path.h"
#include "rig/mesh.h"

namespace thew::muscles {

/// A closed tube along a path: a pole, `rings` rings of `around` nodes, a pole; 2 * around * rings
/// triangles. `radius`: (u in 0..1, m), linear between keys. Rings stand at equal distances.
TriMesh make_tube(const TracedPath& path, int around, int rings,
                  const std::vector<std::array<double, 2>>& radius);

/// Triangles of such a tube; nodes: first pole, ring by ring, last pole.
std::vector<Triangle> tube_triangles(int around, int rings);

}  // namespace thew::muscles
