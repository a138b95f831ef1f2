// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew::rig {

struct ImportedMesh {
  TriMesh mesh;               ///< welded by exact position
  std::vector<int> map_back;  ///< for each vertex of the file, its index in `mesh`; for FBX and
                              ///< Collada, for each vertex as assimp returns them
  int imported_vertices = 0;
  std::vector<std::array<float, 4>> colours;  ///< by vertex of `mesh`; empty if the file has none
  FileOrder order;  ///< for OBJ, PLY and glTF, whose vertices are known in the order of the file
};

/// Reads all triangles of a file (OBJ, STL, PLY, glTF, FBX, Collada) through assimp, in a child
/// process with limits, and welds them. Throws Error(kInput) with the file, the cause and what the
/// user can do.
ImportedMesh import_mesh(const std::filesystem::path& file);

/// While one lives, its thread reads meshes one after another in one child: forking one for each of
/// the 34 of a scene takes longer than the reading. For files that come together, as a scene's do,
/// since what harms the child in one could forge another. What it refuses is read anew by itself.
class SharedReader {
 public:
  SharedReader();
  ~SharedReader();
  SharedReader(const SharedReader&) = delete;
  SharedReader& operator=(const SharedReader&) = delete;

 private:
  bool first_;  ///< else another lives around it
};

/// A number for each vertex of a PLY or glTF file, in its order: a property of the points of the
/// one, a custom attribute ("_THEW_FAT") of the other. Throws Error(kInput), which lists what there
/// is.
std::vector<double> import_attribute(const std::filesystem::path& file, const std::string& name);

/// Throws Error(kInput) with file and vertex if a coordinate is beyond kMaxCoordinate.
void check_positions(const std::filesystem::path& file, const std::vector<Vec3>& positions);

/// Throws Error(kInput) with all defects unless the mesh is a sound closed surface.
void check_closed(const std::string& where, const TriMesh& mesh, Pieces pieces = Pieces::kOne);

/// Imports a mesh and applies `to_world`, the transform from the units and axes of the file to
/// metres in the world. Throws Error(kInput) with all defects if it is then no sound closed
/// surface.
TriMesh import_closed_mesh(const std::filesystem::path& file,
                           const Eigen::Affine3d& to_world = Eigen::Affine3d::Identity());
TriMesh import_bone(const std::filesystem::path& file);
ImportedMesh import_closed_mesh_whole(const std::filesystem::path& file,
                                      const Eigen::Affine3d& to_world,
                                      Pieces pieces = Pieces::kOne);

}  // namespace thew::rig
