// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// Reading through assimp, for the importers of meshes and of characters. Private to the libraries;
// to be called in a child process (child.h).

inline constexpr size_t kAssimpFileLimit = size_t{256} << 20;  // bytes

/// The ending of a file in lower case, without its dot: "glb" for "x.GLB".
std::string lower_ending(const std::filesystem::path& file);
Eigen::Matrix4d to_matrix(const aiMatrix4x4& m);

/// Reads the file with the importer for its ending, confined to its folder, as triangles. FBX is
/// converted to metres and Y up by its header. The scene belongs to `importer`. Throws
/// Error(kInput) if the file cannot be read, or has no mesh and `with_meshes` is true.
const aiScene& read_assimp_scene(const std::filesystem::path& file, bool with_meshes,
                                 Assimp::Importer& importer);

/// Appends the triangles of a mesh, with `first` added to their vertices; points and lines are left
/// out. `mirrored` reverses their winding, for a mesh under a transform that mirrors.
void append_triangles(const std::filesystem::path& file, const aiMesh& part, bool mirrored,
                      int first, std::vector<Triangle>& triangles);

struct Character;
/// Reads an FBX, Collada or BVH as a character, all lengths multiplied by `scale`. Of the skeleton
/// only names and parents are set; the caller makes its frames from `bind`. Throws Error(kInput) if
/// it has no mesh and `with_mesh` is true.
Character read_assimp_character(const std::filesystem::path& file, double scale, bool with_mesh);

}  // namespace thew::rig
