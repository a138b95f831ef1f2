// SPDX-License-Identifier: Apache-2.0
#include "tools/export/looks.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "rig/math.h"
#include "rig/text.h"
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

template <std::size_t n>
std::array<float, n> factors(const nlohmann::json& of, const char* key,
                             std::array<float, n> other) {
  return of.contains(key) ? of[key].get<std::array<float, n>>() : other;
}

std::string image_name(const std::string& given, std::size_t number, const std::string& bytes) {
  std::string name;
  for (const char c : given) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    name += plain || c == '-' ? c : '_';
  }
  name = (name.empty() ? "image" : name) + "_" + std::to_string(number);
  return name + (bytes.starts_with("\x89PNG") ? ".png" : ".jpg");
}

// Its place among the looks' images; -1 where it is not in the file.
int add_image(const nlohmann::json& json, const GltfSource& source, std::size_t texture,
              SkinLooks& looks) {
  const auto& from = json.at("textures").at(texture);
  if (!from.contains("source")) return -1;
  const auto number = from["source"].get<std::size_t>();
  const auto& image = json.at("images").at(number);
  if (!image.contains("bufferView")) return -1;
  const auto& view = json.at("bufferViews").at(image["bufferView"].get<std::size_t>());
  const std::string bytes = source.bytes.substr(view.value("byteOffset", std::size_t{0}),
                                                view.at("byteLength").get<std::size_t>());
  if (!bytes.starts_with("\x89PNG") && !bytes.starts_with("\xff\xd8\xff")) return -1;
  const std::string name = image_name(image.value("name", ""), number, bytes);
  for (std::size_t i = 0; i < looks.images.size(); ++i) {
    if (looks.images[i].name == name) return static_cast<int>(i);
  }
  looks.images.push_back({name, bytes});
  return static_cast<int>(looks.images.size()) - 1;
}

// Of one part of the character; -1 where it has none.
int add_material(const Character& character, std::size_t part, const nlohmann::json& json,
                 const GltfSource& source, SkinLooks& looks) {
  const MeshPart& of = character.parts[part];
  const auto& primitive = json.at("meshes").at(of.mesh_index).at("primitives").at(of.primitive);
  if (!primitive.contains("material")) return -1;
  const auto& from = json.at("materials").at(primitive["material"].get<std::size_t>());
  const auto pbr = from.value("pbrMetallicRoughness", nlohmann::json::object());
  SkinMaterial material{of.material};
  material.colour = factors<4>(pbr, "baseColorFactor", material.colour);
  material.emission = factors<3>(from, "emissiveFactor", material.emission);
  if (from.contains("emissiveTexture")) material.emission = {0, 0, 0};  // which is not carried over
  material.metallic = pbr.value("metallicFactor", 1.0f);
  material.roughness = pbr.value("roughnessFactor", 1.0f);
  const std::string alpha = from.value("alphaMode", "OPAQUE");
  material.see_through = alpha != "OPAQUE";
  if (alpha == "MASK") material.cut = from.value("alphaCutoff", 0.5f);
  if (pbr.contains("baseColorTexture") && pbr["baseColorTexture"].value("texCoord", 0) == 0) {
    const auto texture = pbr["baseColorTexture"].at("index").get<std::size_t>();
    material.image = add_image(json, source, texture, looks);
  }
  looks.materials.push_back(material);
  return static_cast<int>(looks.materials.size()) - 1;
}

// What is wrong in the file's materials leaves the skin without them, and is told: its shape is
// sound.
void add_materials(const Character& character, const GltfSource& source, SkinLooks& looks) {
  try {
    const auto json = nlohmann::json::parse(source.json);
    const auto first_of = [&](const std::string& material) {
      std::size_t p = 0;
      while (p + 1 < character.parts.size() && character.parts[p].material != material) ++p;
      return p;
    };
    for (SkinLooks::Part& part : looks.parts) {
      part.look = add_material(character, first_of(part.material), json, source, looks);
    }
    if (looks.parts.empty() && !character.parts.empty()) {
      looks.look = add_material(character, 0, json, source, looks);
    }
  } catch (const std::exception& error) {  // of the JSON library, or a view beyond the bytes
    looks.unread = printable(error.what());
    looks.materials.clear();
    looks.images.clear();
    looks.look = -1;
    for (SkinLooks::Part& part : looks.parts) part.look = -1;
  }
}

std::vector<SkinLooks::Part> parts_of(const Character& character) {
  std::vector<SkinLooks::Part> parts;
  std::vector<std::size_t> part_of(character.mesh.vertices.size());
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const std::string& material = character.parts[p].material;
    const auto known = std::find_if(parts.begin(), parts.end(),
                                    [&](const auto& part) { return part.material == material; });
    const auto place = static_cast<std::size_t>(known - parts.begin());
    if (known == parts.end()) parts.push_back({material, {}, -1});
    for (int v = character.parts[p].first_vertex; v < end_of_part(character, p); ++v) {
      part_of[v] = place;
    }
  }
  for (std::size_t t = 0; t < character.mesh.triangles.size(); ++t) {
    parts[part_of[character.mesh.triangles[t][0]]].faces.push_back(static_cast<int>(t));
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

Faces faces_of(const Shot& shot, std::size_t m) {
  if (shot.is_own(m)) return shot.own->faces;
  const std::vector<Triangle>& triangles = shot.mesh(m).rest.triangles;
  Faces faces{std::vector<int>(triangles.size(), 3), {}};
  for (const Triangle& t : triangles) faces.corners.insert(faces.corners.end(), t.begin(), t.end());
  return faces;
}

Uvs uvs_of(const Shot& shot, std::size_t m) {
  return shot.meshes[m] == skin_mesh(shot.info()) ? shot.looks.uvs : fibre_uvs(shot.mesh(m));
}

SkinLooks read_skin_looks(const Shot& shot, const std::filesystem::path& file) {
  const GltfSource source = read_gltf_source(file);
  const CharacterSkin skin = read_own_character(shot, file, source);
  const Character& character = skin.character;
  SkinLooks looks{.uvs = {vertex_uvs(character, source), {}},
                  .parts = parts_of(character),
                  .smooth = skin.seam};
  add_materials(character, source, looks);
  for (const Triangle& triangle : character.mesh.triangles) {
    if (looks.uvs.values.empty()) break;
    looks.uvs.corners.insert(looks.uvs.corners.end(), triangle.begin(), triangle.end());
  }
  return looks;
}

}  // namespace thew::tools
