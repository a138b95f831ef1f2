// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "rig/mesh.h"

namespace thew::rig {

struct ImportedMesh {
  TriMesh mesh;               ///< welded by exact position
  std::vector<int> map_back;  ///< index in `mesh` of each vertex of the file, FBX's and Collada's
                              ///< as assimp has them
  int imported_vertices = 0;
  std::vector<std::array<float, 4>> colours;  ///< by vertex of `mesh`; empty: the file has none
  FileOrder order;  ///< of OBJ, PLY and glTF, whose vertices come as the file has them
};

/// Reads all triangles of a file (OBJ, STL, PLY, glTF, FBX, Collada) through assimp, in a child
/// process with limits, and welds them. Throws Error(kInput) with file, cause and next move.
ImportedMesh import_mesh(const std::filesystem::path& file);

/// Error(kInput) with file and vertex for what is farther than kFarthest.
void check_places(const std::filesystem::path& file, const std::vector<Vec3>& places);

/// import_mesh, and Error(kInput) listing every defect when the mesh is not a sound closed surface.
/// `place` takes the file's metres (or millimetres) to where the mesh belongs; it is checked there.
TriMesh import_closed_mesh(const std::filesystem::path& file,
                           const Eigen::Affine3d& place = Eigen::Affine3d::Identity());
ImportedMesh import_closed_mesh_whole(const std::filesystem::path& file,
                                      const Eigen::Affine3d& place);

}  // namespace thew::rig
