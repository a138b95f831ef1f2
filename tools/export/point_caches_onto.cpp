// SPDX-License-Identifier: Apache-2.0
//
// A character of several meshes as point caches: one of each mesh, whose points are the vertices of
// its primitives one after another, as programs that read the file have them.
#include <map>
#include <set>

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

}  // namespace

std::vector<CachedNode> point_cache_nodes(const Shot& shot, const std::filesystem::path& file,
                                          const std::filesystem::path& character) {
  const CharacterSkin skin = read_own_character(shot, character, read_gltf_source(character));
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
          "one cache for each mesh of the character, in the order of its file; " + note};
}

}  // namespace thew::tools
