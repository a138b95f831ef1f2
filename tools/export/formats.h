// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// What an exporter wrote, and what there is to say of it beyond facts_of().
struct Exported {
  std::vector<std::filesystem::path> files;
  std::string note;
};

/// One mesh, positions as float32: point_cache.cpp. Beside FILE.pc2 or FILE.mdd stands
/// FILE.rest.obj, the mesh that the cache is to be put on, which also states what they cannot.
/// `vertices`: those of it, in the order of the points; empty: all.
Exported export_pc2(const Shot& shot, const std::filesystem::path& file,
                    const std::vector<int>& vertices = {});
Exported export_mdd(const Shot& shot, const std::filesystem::path& file,
                    const std::vector<int>& vertices = {});
/// The same for each mesh of a bake's character, the only mesh of the shot being its skin: FILE's
/// name with that of the mesh's node before the ending. point_caches_onto.cpp.
struct CachedNode {
  std::filesystem::path file;
  std::vector<int> vertices;  ///< of the bake's skin
};
std::vector<CachedNode> point_cache_nodes(const Shot& shot, const std::filesystem::path& file,
                                          const std::filesystem::path& character);
Exported export_point_caches_onto(const Shot& shot, const std::vector<CachedNode>& nodes);
std::filesystem::path rest_file(const std::filesystem::path& cache);

/// One file a frame, #### in the name being its number: NAME.####.obj where there is none.
/// OBJ: all meshes, with normals. PLY: one mesh, with normals and velocities.
Exported export_obj(const Shot& shot, const std::filesystem::path& file);
Exported export_ply(const Shot& shot, const std::filesystem::path& file);

/// glTF 2, binary: a morph target a frame, or, with `basis` > 0, so many of the best. `quantized`:
/// displacements in whole steps of KHR_mesh_quantization, half as large; without a basis. gltf.cpp.
struct GlbOptions {
  int basis = 0;
  bool quantized = false;
};
Exported export_glb(const Shot& shot, const std::filesystem::path& file, const GlbOptions& options);

/// A bake's skin, the only mesh of the shot, put back onto its character: the character's own glTF
/// file with the skin as baked, gltf_onto.cpp.
struct OntoOptions {
  std::filesystem::path file, character;
  bool correctives = false;  ///< keep skeleton, weights and animation; targets only add to them
  int basis = 0;             ///< > 0: so many of the best morph targets instead of one a frame
};
Exported export_glb_onto(const Shot& shot, const OntoOptions& options);

/// XDMF 3 beside the bake, whose numbers it points to: xdmf.cpp.
Exported export_xdmf(const Shot& shot, const std::filesystem::path& file,
                     const std::filesystem::path& bake);

/// USD by the file's ending, as text (.usda), binary (.usdc) or that in an archive (.usdz): usd/.
/// Images of the skin's materials stand in the archive, or beside the file.
Exported export_usd(const Shot& shot, const std::filesystem::path& file);
std::vector<std::filesystem::path> usd_images(const Shot& shot, const std::filesystem::path& file);

/// Alembic in Ogawa's container, positions, normals and velocities by frame: alembic.cpp.
Exported export_alembic(const Shot& shot, const std::filesystem::path& file);

}  // namespace thew::tools
