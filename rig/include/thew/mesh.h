// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "thew/error.h"

namespace thew {

/// A triangle surface as two flat arrays.
struct Mesh {
  std::vector<double> positions;  ///< m; x, y, z of each vertex
  std::vector<int> triangles;     ///< three vertices each, counter-clockwise seen from outside
};

/// Volume (m^3) that a closed surface encloses; negative where it is inside out. Hong et al. 2006,
/// eq. 1, summed about the vertices' centroid. Error(kUsage) for arrays that do not fit.
double enclosed_volume(std::span<const double> positions, std::span<const int> triangles);

/// One kind of defect of a surface.
struct MeshDefect {
  std::string name;   ///< "open edge"
  int count = 0;      ///< how many there are
  std::string where;  ///< the first one: "edge 12-47 at (0.01, 0.2, 0)"
  std::string fix;    ///< what to do about it
};
/// All that is wrong with the mesh as a closed, outward, manifold surface of a size between 5 mm
/// and 3 m; empty where it is sound. A muscle, a bone and a skin have to be. Vertices that lie in
/// one place but are not joined make open edges: see read_mesh(). Error(kUsage) for arrays whose
/// length is no multiple of three.
std::vector<MeshDefect> find_defects(const Mesh& mesh);

/// A mesh as Thew works on it, and as its file has it.
struct MeshFile {
  Mesh welded;  ///< vertices of exactly equal position joined, in order of first appearance
  /// The file's own vertices in the file's order, of OBJ, PLY and glTF; else as `welded`.
  Mesh in_file_order;
  std::vector<int> welded_vertex;  ///< by vertex of `in_file_order`: which of `welded` it is
};
/// Reads all triangles of an OBJ, STL, PLY, glTF, FBX or Collada file, in the file's unit, in a
/// process of its own (see import.h). Error(kInput) with file, cause and next move.
MeshFile read_mesh(const std::filesystem::path& file);

}  // namespace thew
