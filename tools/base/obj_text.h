// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rig/mesh.h"

namespace thew::tools {

/// Metres with nine places, without the zeros at the end.
std::string metres(double value);
std::string metres(const Vec3& p, const char* between);
/// Its vertices in the order in which its triangles name them.
TriMesh in_order_of_use(const TriMesh& mesh);
/// An OBJ of vertices and triangles; `what` is its first line.
std::string obj_text(const std::string& what, const TriMesh& mesh, const Vec3& shift);

}  // namespace thew::tools
