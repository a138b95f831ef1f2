// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "sim/cache/cache.h"

namespace thew::tools {

/// "muscle", "bone", "skin" or "prop"
const char* kind_name(BakeMesh::Kind kind);
/// What exports paint it with: red, green and blue, linear.
std::array<double, 3> kind_colour(BakeMesh::Kind kind);

/// The triangles by which a mesh is shaded: flesh and bone are smooth, and so go by the first
/// vertex of each place at rest; a skin may have vertices apart for the sake of a sharp edge.
std::vector<Triangle> shaded_triangles(const BakeMesh& mesh);

}  // namespace thew::tools
