// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "rig/mesh_motion.h"
#include "sim/cache/bake_frame.h"

namespace thew::sim {

/// An animated mesh of a file: a mesh of a bake, or an OBJ (or another mesh) with a point cache.
struct CachedMesh {
  std::string name;  ///< in the bake; else ""
  TriMesh rest;      ///< m, welded
  MeshSamples samples;
};

/// Where the mesh lies in a bake: which one, and of which kind; "" and none for the only one.
struct CachedPart {
  std::string name;
  std::optional<BakeMesh::Kind> kind;
};

bool names_bake(const std::filesystem::path& file);
/// Positions of all vertices of the file; `scale` multiplies them. Error(kInput) with the file.
CachedMesh read_cached_mesh(const std::filesystem::path& mesh, const std::filesystem::path& cache,
                            double fps, double scale, Pieces pieces = Pieces::kOne);
/// One mesh of a bake. Error(kInput) where there is none of the name or, without a name, several.
CachedMesh read_baked_mesh(const std::filesystem::path& bake, const CachedPart& part, double scale);
/// All bones of a bake, in the order of their names.
std::vector<CachedMesh> read_baked_bones(const std::filesystem::path& bake, double scale);

}  // namespace thew::sim
