// SPDX-License-Identifier: Apache-2.0
//
// Numbers by vertex that assimp leaves out: custom attributes of glTF, point attributes of PLY.
#include <bit>
#include <functional>
#include <limits>

#include "rig/import/assimp_scene.h"
#include "rig/import/character_import.h"
#include "rig/import/child.h"
#include "rig/import/gltf_file.h"
#include "rig/import/gltf_source.h"
#include "rig/import/mesh_import.h"
#include "rig/import/packed.h"
#include "rig/limits.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;
using Json = GltfFile::Json;

[[noreturn]] void refuse_name(const fs::path& file, const std::string& name,
                              const std::vector<std::string>& names) {
  refuse_file(file, "has no attribute \"" + name + "\" of one number by vertex" +
                        did_you_mean(name, names) +
                        "; it has: " + (names.empty() ? "none" : names_text(names)));
}

// Of all nodes depth first, as assimp goes through them.
std::vector<double> gltf_attribute(const fs::path& file, const std::string& name) {
  constexpr int kDeepest = 1000;
  GltfFile gltf(file);
  std::vector<double> values;
  std::vector<std::string> names;
  const auto add_primitive = [&](const Json& primitive, const std::string& from) {
    if (!primitive.is_object()) gltf.refuse(from + ": a primitive is none");
    const Json attributes = primitive.value("attributes", Json::object());
    if (!attributes.is_object() || !attributes.contains("POSITION")) return;
    if (primitive.value("mode", 4) < 4) return;  // points and lines
    const auto at = gltf.index_of(attributes, "POSITION", from);
    const size_t vertices = gltf.index_of(gltf.item("accessors", at, from), "count", from);
    for (const auto& [key, one] : attributes.items()) {
      if (key.starts_with('_')) names.push_back(key);
    }
    if (!attributes.contains(name)) refuse_name(file, name, names);
    const auto numbers = gltf.numbers(gltf.index_of(attributes, name.c_str(), from), 1);
    if (numbers.size() != vertices) {
      gltf.refuse(from + ": attribute \"" + name + "\" has " + std::to_string(numbers.size()) +
                  " numbers for " + std::to_string(vertices) + " vertices");
    }
    values.insert(values.end(), numbers.begin(), numbers.end());
  };
  const std::function<void(size_t, int)> visit = [&](size_t index, int depth) {
    const std::string from = "nodes[" + std::to_string(index) + "]";
    if (depth > kDeepest) gltf.refuse(from + " hangs too deep");
    const Json& node = gltf.item("nodes", index, from);
    if (node.contains("mesh")) {
      const Json& mesh = gltf.item("meshes", gltf.index_of(node, "mesh", from), from);
      const Json primitives = mesh.value("primitives", Json::array());
      for (const Json& primitive : primitives) add_primitive(primitive, from);
    }
    const Json children = node.value("children", Json::array());
    for (const Json& child : children) {
      if (!child.is_number_unsigned()) gltf.refuse(from + " has a child that is none");
      visit(child.get<size_t>(), depth + 1);
    }
  };
  const size_t chosen = gltf.index_or(gltf.json(), "scene", 0, "scene");
  const Json roots = gltf.item("scenes", chosen, "scene").value("nodes", Json::array());
  for (const Json& root : roots) {
    if (!root.is_number_unsigned()) gltf.refuse("scenes: a node is none");
    visit(root.get<size_t>(), 0);
  }
  return values;
}

// Of the parts of a character, in their order. A colour has three numbers or four, all else one.
std::vector<double> parts_attribute(const fs::path& file, const std::string& name, int channel,
                                    const Character& of) {
  GltfFile gltf(file);
  std::vector<double> values(of.mesh.vertices.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<std::string> names;
  bool found = false;
  for (size_t p = 0; p < of.parts.size(); ++p) {
    const MeshPart& part = of.parts[p];
    const std::string from = "meshes[" + std::to_string(part.mesh_index) + "].primitives[" +
                             std::to_string(part.primitive) + "]";
    const Json& mesh = gltf.item("meshes", part.mesh_index, "parts");
    const Json& attributes = mesh.at("primitives").at(part.primitive).at("attributes");
    for (const auto& [key, one] : attributes.items()) {
      if (key.starts_with('_')) names.push_back(key);
    }
    if (!attributes.contains(name)) continue;
    const size_t accessor = gltf.index_of(attributes, name.c_str(), from);
    const std::string type = GltfFile::text_of(gltf.item("accessors", accessor, from), "type");
    const size_t width = channel < 0 ? 1 : type == "VEC3" ? 3 : 4;
    if (channel >= static_cast<int>(width)) gltf.refuse(from + ": its colours have no alpha");
    const std::vector<double> numbers = gltf.numbers(accessor, width);
    const size_t first = part.first_vertex;
    const size_t end = p + 1 < of.parts.size() ? of.parts[p + 1].first_vertex : values.size();
    if (numbers.size() != width * (end - first)) {
      gltf.refuse(from + ": attribute \"" + name + "\" has " +
                  std::to_string(numbers.size() / width) + " numbers for " +
                  std::to_string(end - first) + " vertices");
    }
    for (size_t i = first; i < end; ++i) {
      values[i] = numbers[width * (i - first) + std::max(channel, 0)];
    }
    found = true;
  }
  if (!found && channel < 0) refuse_name(file, name, names);
  if (!found) refuse_file(file, "has no vertex colours; export it with them");
  return values;
}

// One property of the vertices of a PLY.
struct Property {
  std::string name;
  size_t bytes;  // in a binary file
  char kind;     // 'i', 'u' or 'f'
};

Property property_of(const fs::path& file, std::string_view type, std::string_view name) {
  const std::tuple<const char*, size_t, char> types[] = {
      {"char", 1, 'i'},  {"int8", 1, 'i'},    {"uchar", 1, 'u'},  {"uint8", 1, 'u'},
      {"short", 2, 'i'}, {"int16", 2, 'i'},   {"ushort", 2, 'u'}, {"uint16", 2, 'u'},
      {"int", 4, 'i'},   {"int32", 4, 'i'},   {"uint", 4, 'u'},   {"uint32", 4, 'u'},
      {"float", 4, 'f'}, {"float32", 4, 'f'}, {"double", 8, 'f'}, {"float64", 8, 'f'}};
  for (const auto& [word, bytes, kind] : types) {
    if (type == word) return {std::string(name), bytes, kind};
  }
  refuse_file(file, "a vertex has a property of type \"" + std::string(type) +
                        "\"; export its points with plain numbers");
}

double number_at(std::string_view bytes, const Property& of, bool big_endian) {
  std::uint64_t word = 0;
  for (size_t k = 0; k < of.bytes; ++k) {
    const size_t at = big_endian ? of.bytes - 1 - k : k;
    word |= std::uint64_t{static_cast<unsigned char>(bytes[at])} << (8 * k);
  }
  if (of.kind == 'f' && of.bytes == 8) return std::bit_cast<double>(word);
  if (of.kind == 'f') return std::bit_cast<float>(static_cast<std::uint32_t>(word));
  if (of.kind == 'u') return static_cast<double>(word);
  const unsigned unused = 64 - 8 * static_cast<unsigned>(of.bytes);
  return static_cast<double>(static_cast<std::int64_t>(word << unused) >> unused);
}

struct PlyHeader {
  std::string format;
  size_t vertices = 0, body = 0;  // number of them; first byte after the header
  bool vertices_first = false;
  std::vector<Property> properties;
};

PlyHeader ply_header(const fs::path& file, std::string_view bytes) {
  PlyHeader header;
  int elements = 0;
  for (size_t begin = 0; begin < bytes.size();) {
    const size_t end = std::min(bytes.find('\n', begin), bytes.size());
    const auto words = split_words(bytes.substr(begin, end - begin));
    begin = end + 1;
    if (words.empty()) continue;
    if (words[0] == "end_header") {
      header.body = std::min(begin, bytes.size());
      return header;
    }
    if (words[0] == "format" && words.size() > 1) header.format = words[1];
    if (words[0] == "element" && words.size() == 3 && ++elements == 1) {
      const auto count = parse_number(words[2]);
      header.vertices_first = words[1] == "vertex" && count && *count >= 0.0 &&
                              *count <= static_cast<double>(bytes.size());
      if (header.vertices_first) header.vertices = static_cast<size_t>(*count);
    }
    if (words[0] == "property" && elements == 1) {
      if (words.size() < 3) refuse_file(file, "a property has no name; export it again");
      header.properties.push_back(property_of(file, words[1], words.back()));
    }
  }
  refuse_file(file, "its header does not end; the file is cut short, export it again");
}

std::vector<double> ply_attribute(const fs::path& file, const std::string& name) {
  const std::string bytes = read_in_child(file_of_child(), kAssimpFileLimit);
  const PlyHeader header = ply_header(file, bytes);
  if (!header.vertices_first)
    refuse_file(file, "does not begin with its vertices; export it again");
  size_t column = header.properties.size(), offset = 0, stride = 0;
  std::vector<std::string> names;
  for (size_t k = 0; k < header.properties.size(); ++k) {
    if (header.properties[k].name == name) column = k, offset = stride;
    names.push_back(header.properties[k].name);
    stride += header.properties[k].bytes;
  }
  if (column == header.properties.size()) refuse_name(file, name, names);
  const auto cut_short = [&] { refuse_file(file, "ends before its last vertex; export it again"); };
  std::vector<double> values;
  std::string_view left = std::string_view(bytes).substr(header.body);
  for (size_t i = 0; i < header.vertices; ++i) {
    if (header.format == "ascii") {
      const size_t end = std::min(left.find('\n'), left.size());
      const auto words = split_words(left.substr(0, end));
      const auto number = column < words.size() ? parse_number(words[column]) : std::nullopt;
      if (!number) cut_short();
      values.push_back(*number);
      left.remove_prefix(std::min(end + 1, left.size()));
      continue;
    }
    if (left.size() < stride) cut_short();
    values.push_back(number_at(left.substr(offset), header.properties[column],
                               header.format == "binary_big_endian"));
    left.remove_prefix(stride);
  }
  return values;
}

// What a child reads of the file.
std::vector<double> numbers_of(const fs::path& file,
                               const std::function<std::vector<double>()>& read) {
  check_readable(file, kAssimpFileLimit);
  Child child(file, "export it again", [&](std::string_view) {
    Packer packer;
    packer.list(read());
    return packer.bytes;
  });
  const std::string bytes = child.ask();
  std::vector<double> values;
  Unpacker unpacker{bytes};
  unpacker.list(values);
  if (!unpacker.finished()) child.refuse("its reader sent nonsense");
  return values;
}

}  // namespace

std::vector<double> import_attribute(const fs::path& file, const std::string& name) {
  const bool ply = lower_ending(file) == "ply";
  if (!ply && !names_gltf(file)) {
    refuse_file(file, "attributes are read from PLY and glTF; export it as one of them");
  }
  return numbers_of(file,
                    [&] { return ply ? ply_attribute(file, name) : gltf_attribute(file, name); });
}

std::vector<double> import_attribute(const fs::path& file, const std::string& name, int channel,
                                     const Character& of) {
  if (!names_gltf(file)) {
    refuse_file(
        file,
        "attributes and colours of a character are read from glTF; export it as that, or name "
        "a mesh that has them as `file`");
  }
  const auto values = numbers_of(file, [&] { return parts_attribute(file, name, channel, of); });
  if (values.size() != of.mesh.vertices.size()) refuse_file(file, "its reader sent nonsense");
  return values;
}

}  // namespace thew::rig
