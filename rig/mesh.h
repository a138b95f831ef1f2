// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

/// A triangle mesh, positions in metres. A closed one is wound so that its normals point outwards.
struct TriMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Enclosed volume (m^3) of a closed surface, V = sum over triangles of x1 . (x2 x x3) / 6, with
/// positions relative to the vertices' centroid to keep the rounding error small.
double enclosed_volume(const TriMesh& mesh);
double enclosed_volume(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles);

/// Unit normals, one for each vertex: the mean of those of its triangles, weighted by area. Zero
/// for a vertex whose triangles have no area.
std::vector<Vec3> vertex_normals(const TriMesh& mesh);

/// Merges vertices of exactly equal position, in order of first appearance, and drops triangles
/// that become degenerate. `map_back[i]` is the new index of input vertex i.
struct WeldResult {
  TriMesh mesh;
  std::vector<int> map_back;
};
WeldResult weld(const TriMesh& mesh);

/// For each vertex, the first vertex of exactly the same position.
std::vector<int> first_at_position(const TriMesh& mesh);
/// The triangles with each vertex replaced by the first vertex of the same position.
std::vector<Triangle> joined_triangles(const TriMesh& mesh);

/// The vertices and triangles of a mesh in the order of its file, for a file that has several
/// vertices of one position, such as along the seams of a texture. Empty if the file has no such
/// vertices: its order is then that of the welded mesh.
struct FileOrder {
  std::vector<int> node;            ///< for each vertex of the file, its vertex in the welded mesh
  std::vector<Triangle> triangles;  ///< those of the welded mesh, by vertices of the file
};

/// Values by vertex of the welded mesh, rearranged by vertex of the file.
template <typename T>
std::vector<T> in_file_order(const FileOrder& order, std::vector<T> by_node) {
  if (order.node.empty() || by_node.empty()) return by_node;
  std::vector<T> out;
  out.reserve(order.node.size());
  for (const int node : order.node) out.push_back(by_node[node]);
  return out;
}

/// One kind of defect: how many there are, and where the first one lies.
struct Defect {
  enum Kind {
    kNotFinite,
    kIndexOutOfRange,
    kOpenEdge,
    kNonManifoldEdge,
    kNonManifoldVertex,
    kInconsistentWinding,
    kInsideOut,
    kZeroArea,
    kSeveralComponents,
    kWrongScale,
    kUnusedVertex,
  } kind;
  int count = 0;
  /// Component, element and coordinates of the first: "edge 12-47 at (0.01, 0.2, 0)".
  std::string where;
  std::string fix;  ///< what the user can do
};
const char* defect_name(Defect::Kind kind);

/// Plausible extents (m) along the longest axis of one part of a character. A mesh outside them is
/// taken to be in another unit.
struct ScaleRange {
  double smallest = 0.005, largest = 3.0;
};

/// A muscle or a skin is one closed surface; a bone may be in pieces, as those of a hand.
enum class Pieces { kOne, kAny };

/// All defects that keep the mesh from being a closed manifold surface that faces outwards; empty
/// for a sound one.
std::vector<Defect> find_defects(const TriMesh& mesh, const ScaleRange& scale = {});

}  // namespace thew::rig
