// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rig/character.h"
#include "rig/import/gltf_source.h"
#include "tools/export/shot.h"

namespace thew::tools {

/// The skin of a bake on the character whose mesh it is. All lengths are in the units of the
/// character's file, which the scene may have scaled; vertices are in the order of
/// Character::mesh, of which each part is one primitive of the file.
struct CharacterSkin {
  Character character;
  double scale = 1.0;                       ///< m of the bake for one unit of the file
  std::vector<std::vector<Affine>> bodies;  ///< by frame, body: world transforms
  std::vector<std::vector<Vec3>> baked;     ///< by frame, vertex: world positions
  Shape raw;                ///< as the file has it; a normal that it does not have is zero
  std::vector<char> moved;  ///< by vertex, whether it is anywhere else than its weights carry it
  std::vector<int> seam;    ///< by vertex, the first one of the same place and normal
};

/// The place of the skin among the meshes of a bake; -1 where it has none.
int skin_mesh(const BakeInfo& info);

/// The character alone, without what is by frame. Error(kUsage) where the bake has no character's
/// own skin, Error(kInput) where the file is not that character: its mesh has to lie at rest where
/// the bake's lies.
CharacterSkin read_own_character(const Shot& shot, const std::filesystem::path& file,
                                 const GltfSource& source);

/// The same with the bake's skin on it.
CharacterSkin read_character_skin(const Shot& shot, const std::filesystem::path& file,
                                  const GltfSource& source);

/// The skin of each frame in the bind pose, in the file's frame of each mesh: there the weights
/// carry it to where it is baked. Positions that weights alone carry there, and normals beside
/// them, are those of the file.
std::vector<Shape> corrected_shapes(const CharacterSkin& skin);

/// The skin of each frame as the bake has it, in the world. Normals lie to the surface as those of
/// the file do.
std::vector<Shape> world_shapes(const CharacterSkin& skin);

/// The index of the first vertex after a part.
int end_of_part(const Character& character, std::size_t part);

}  // namespace thew::tools
