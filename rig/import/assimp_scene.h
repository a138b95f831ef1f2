// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// What the importers of meshes and of characters share of assimp. Private to the libraries; to be
// called in a child process (child.h).

inline constexpr size_t kAssimpFileLimit = size_t{256} << 20;  // bytes

/// "glb" of "x.GLB".
std::string lower_ending(const std::filesystem::path& file);
Eigen::Matrix4d to_matrix(const aiMatrix4x4& m);

/// Reads the file by the importer of its own ending, confined to its folder, as triangles, in
/// metres and Y up where the format names its unit and axes. The scene belongs to `importer`.
/// `with_meshes`: without a mesh it is Error(kInput).
const aiScene& read_assimp_scene(const std::filesystem::path& file, bool with_meshes,
                                 Assimp::Importer& importer);

/// The part's triangles, its vertices counted from `first` on; points and lines are left out.
/// `mirrored`: turned about, to face out again.
void append_triangles(const std::filesystem::path& file, const aiMesh& part, bool mirrored,
                      int first, std::vector<Triangle>& triangles);

struct Character;
/// FBX, Collada and BVH as a character: of the skeleton names and parents alone; its frames come
/// from `bind`. In metres times `scale`. `with_mesh`: without one it is Error(kInput).
Character read_assimp_character(const std::filesystem::path& file, double scale, bool with_mesh);

}  // namespace thew::rig
