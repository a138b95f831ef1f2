// SPDX-License-Identifier: Apache-2.0
#include "tools/export/looks.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "rig/math.h"
#include "tools/export/character_skin.h"

namespace thew::tools {
namespace {

// By vertex; empty where the file has none.
std::vector<std::array<float, 2>> vertex_uvs(const Character& character, const GltfSource& source) {
  const auto json = nlohmann::json::parse(source.json);
  std::vector<std::array<float, 2>> uvs(character.mesh.vertices.size(), {0.0f, 0.0f});
  bool any = false;
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const MeshPart& part = character.parts[p];
    const auto& attributes =
        json.at("meshes").at(part.mesh_index).at("primitives").at(part.primitive).at("attributes");
    if (!attributes.contains("TEXCOORD_0")) continue;
    const int accessor = attributes["TEXCOORD_0"].get<int>();
    const auto first = static_cast<std::size_t>(part.first_vertex),
               count = static_cast<std::size_t>(end_of_part(character, p)) - first;
    for (const auto& [of, values] : source.vectors) {
      if (of != accessor || values.size() != count) continue;
      any = true;
      for (std::size_t v = 0; v < count; ++v) {
        uvs[first + v] = {static_cast<float>(values[v].x()), static_cast<float>(1 - values[v].y())};
      }
    }
  }
  return any ? uvs : std::vector<std::array<float, 2>>();
}

std::vector<SkinLooks::Part> parts_of(const Character& character) {
  std::vector<SkinLooks::Part> parts;
  std::vector<std::size_t> part_of(character.mesh.vertices.size());
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const std::string& material = character.parts[p].material;
    const auto known = std::find_if(parts.begin(), parts.end(),
                                    [&](const auto& part) { return part.material == material; });
    const auto place = static_cast<std::size_t>(known - parts.begin());
    if (known == parts.end()) parts.push_back({material, {}});
    for (int v = character.parts[p].first_vertex; v < end_of_part(character, p); ++v) {
      part_of[v] = place;
    }
  }
  for (std::size_t t = 0; t < character.mesh.triangles.size(); ++t) {
    parts[part_of[character.mesh.triangles[t][0]]].triangles.push_back(static_cast<int>(t));
  }
  if (parts.size() < 2) parts.clear();
  return parts;
}

}  // namespace

Uvs fibre_uvs(const BakeMesh& mesh) {
  Uvs uvs;
  if (mesh.coordinates.empty()) return uvs;
  std::map<std::array<float, 2>, int> numbers;
  for (const Triangle& triangle : mesh.rest.triangles) {
    const double first = mesh.coordinates[triangle[0]][1];
    for (const int vertex : triangle) {
      const auto& [along, angle, belly] = mesh.coordinates[vertex];
      // A triangle across the seam goes on beyond it.
      const double turns = std::round((angle - first) / (2.0 * kPi));
      const std::array<float, 2> uv = {static_cast<float>(angle / (2.0 * kPi) + 0.5 - turns),
                                       static_cast<float>(along)};
      const auto [found, added] = numbers.try_emplace(uv, static_cast<int>(uvs.values.size()));
      if (added) uvs.values.push_back(uv);
      uvs.corners.push_back(found->second);
    }
  }
  return uvs;
}

Uvs uvs_of(const Shot& shot, std::size_t m) {
  return shot.meshes[m] == skin_mesh(shot.info()) ? shot.looks.uvs : fibre_uvs(shot.mesh(m));
}

SkinLooks read_skin_looks(const Shot& shot, const std::filesystem::path& file) {
  const GltfSource source = read_gltf_source(file);
  const CharacterSkin skin = read_own_character(shot, file, source);
  const Character& character = skin.character;
  SkinLooks looks{{vertex_uvs(character, source), {}}, parts_of(character), skin.seam};
  for (const Triangle& triangle : character.mesh.triangles) {
    if (looks.uvs.values.empty()) break;
    looks.uvs.corners.insert(looks.uvs.corners.end(), triangle.begin(), triangle.end());
  }
  return looks;
}

}  // namespace thew::tools
