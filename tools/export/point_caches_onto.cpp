// SPDX-License-Identifier: Apache-2.0
//
// A character of several meshes as point caches: one of each mesh, whose points are the vertices of
// its primitives one after another, as programs that read the file have them; or, where these have
// the attribute _thew_vertex, those of the mesh that the file was written from, by that number.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "rig/import/character_import.h"
#include "rig/text.h"
#include "tools/base/output_file.h"
#include "tools/export/character_skin.h"
#include "tools/export/formats.h"

namespace thew::tools {
namespace {

std::string file_name(const std::string& name, std::set<std::string>& taken) {
  std::string result;
  for (const char c : name) {
    const bool bad = static_cast<unsigned char>(c) <= ' ' || c == '/' || c == '\\' || c == 127;
    result += bad ? '_' : c;
  }
  if (result.empty()) result = "mesh";
  while (!taken.insert(result).second) result += "_";
  return result;
}

// By vertex of the character its number in the mesh that the file was written from, no number where
// the file does not say; empty where it says so of none.
std::vector<double> own_numbers(const std::filesystem::path& file, const Character& character,
                                const GltfSource& source) {
  const auto json = nlohmann::json::parse(source.json);
  for (const MeshPart& part : character.parts) {
    const auto& primitive = json.at("meshes").at(part.mesh_index).at("primitives");
    for (const auto& [name, accessor] : primitive.at(part.primitive).at("attributes").items()) {
      // Blender 3.4 writes capitals, and one more underscore before.
      std::string plain = name.substr(std::min(name.find_first_not_of('_'), name.size()));
      for (char& c : plain) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (plain == "thew_vertex" && plain != name)
        return import_attribute(file, name, -1, character);
    }
  }
  return {};
}

// Vertices of one mesh, in the order of their numbers; a file has several where a seam splits one.
std::vector<int> by_number(const std::string& where, const std::vector<Vec3>& rest,
                           const std::vector<double>& numbers, const std::vector<int>& vertices) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kInput,
                where + ": _thew_vertex " + what +
                    "; number the points of the mesh from 0 and export it again");
  };
  std::vector<int> ordered;
  for (const int v : vertices) {
    const double number = numbers[v];
    if (!(number >= 0.0 && number < 1e7 && number == std::floor(number))) {
      refuse("of vertex " + std::to_string(v) + " is " + number_text(number));
    }
    const auto place = static_cast<std::size_t>(number);
    if (place >= ordered.size()) ordered.resize(place + 1, -1);
    if (ordered[place] >= 0 && (rest[v] - rest[ordered[place]]).norm() > 1e-6) {  // m
      refuse("is " + number_text(number) + " at two places");
    }
    if (ordered[place] < 0) ordered[place] = v;
  }
  const auto lost = std::find(ordered.begin(), ordered.end(), -1);
  if (lost != ordered.end()) {
    refuse("has no " + std::to_string(lost - ordered.begin()) + " of " +
           std::to_string(ordered.size()) + ", as of a point without faces");
  }
  return ordered;
}

}  // namespace

std::vector<CachedNode> point_cache_nodes(const Shot& shot, const std::filesystem::path& file,
                                          const std::filesystem::path& character) {
  const GltfSource source = read_gltf_source(character);
  const CharacterSkin skin = read_own_character(shot, character, source);
  const std::vector<double> numbers = own_numbers(character, skin.character, source);
  std::map<int, std::vector<std::size_t>> parts;  // by node
  for (std::size_t p = 0; p < skin.character.parts.size(); ++p) {
    parts[skin.character.parts[p].node_index].push_back(p);
  }
  std::vector<CachedNode> nodes;
  std::set<std::string> taken;
  for (const auto& [node, of] : parts) {
    const MeshPart& first = skin.character.parts[of.front()];
    const std::string name = file_name(first.node.empty() ? first.mesh : first.node, taken);
    CachedNode& cached = nodes.emplace_back();
    cached.file =
        file.parent_path() / (file.stem().string() + "." + name + file.extension().string());
    for (const std::size_t p : of) {
      for (int v = skin.character.parts[p].first_vertex; v < end_of_part(skin.character, p); ++v) {
        cached.vertices.push_back(v);
      }
    }
    if (numbers.empty() || std::all_of(cached.vertices.begin(), cached.vertices.end(),
                                       [&](int v) { return std::isnan(numbers[v]); })) {
      continue;
    }
    cached.vertices = by_number(character.string() + ": mesh \"" + name + "\"",
                                shot.mesh(0).rest.vertices, numbers, cached.vertices);
  }
  return nodes;
}

Exported export_point_caches_onto(const Shot& shot, const std::vector<CachedNode>& nodes) {
  WrittenFiles written;
  std::string note;
  for (const CachedNode& node : nodes) {
    const Exported one = node.file.extension() == ".pc2"
                             ? export_pc2(shot, node.file, node.vertices)
                             : export_mdd(shot, node.file, node.vertices);
    for (const auto& file : one.files) written.add(file);
    note = one.note;
  }
  return {written.keep(),
          "one cache for each mesh of the character, in the order of its file, or by its "
          "_thew_vertex; " +
              note};
}

}  // namespace thew::tools
