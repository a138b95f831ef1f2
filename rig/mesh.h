// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

/// A triangle surface in metres; outward winding when closed.
struct TriMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

/// Enclosed volume (m^3) of a closed surface, summed about its centroid.
double enclosed_volume(const TriMesh& mesh);

/// Area-weighted unit normals, one per vertex.
std::vector<Vec3> vertex_normals(const TriMesh& mesh);

/// Merges vertices of exactly equal position, in order of first appearance, and drops triangles
/// that become degenerate by it. `map_back[i]` is the new index of the i-th input vertex.
struct WeldResult {
  TriMesh mesh;
  std::vector<int> map_back;
};
WeldResult weld(const TriMesh& mesh);

/// Of each vertex the first one at exactly its place.
std::vector<int> first_at_place(const TriMesh& mesh);
/// The triangles, with the first vertex of each place for all that are there.
std::vector<Triangle> joined_triangles(const TriMesh& mesh);

/// A mesh as its file has it, where several of the file's vertices lie at one place, as along the
/// seams of a texture. Empty: as it is once they are joined.
struct FileOrder {
  std::vector<int> node;            ///< of each vertex of the file
  std::vector<Triangle> triangles;  ///< the joined mesh's, by vertices of the file
};

/// Values by node as values by vertex of the file.
template <typename T>
std::vector<T> by_file(const FileOrder& order, std::vector<T> by_node) {
  if (order.node.empty() || by_node.empty()) return by_node;
  std::vector<T> out;
  out.reserve(order.node.size());
  for (const int node : order.node) out.push_back(by_node[node]);
  return out;
}

/// One kind of defect: how many there are, and the first one with its place.
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
  std::string where;  ///< "edge 12-47 at (0.01, 0.2, 0)": component, first place with coordinates
  std::string fix;    ///< the next move
};
const char* defect_name(Defect::Kind kind);

/// Largest plausible extent (m) of one part of a character; a mesh beyond it is in other units.
struct ScaleRange {
  double smallest = 0.005, largest = 3.0;
};

/// Everything that is wrong with the mesh as a closed, outward, manifold surface; empty when sound.
std::vector<Defect> find_defects(const TriMesh& mesh, const ScaleRange& scale = {});

}  // namespace thew::rig
