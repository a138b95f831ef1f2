// SPDX-License-Identifier: Apache-2.0
#include "rig/import/gltf_source.h"

#include <algorithm>
#include <set>

#include "rig/import/assimp_scene.h"
#include "rig/import/child.h"
#include "rig/import/gltf_file.h"
#include "rig/import/packed.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;
using Json = GltfFile::Json;

// Extensions that hold a mesh a second time, packed, and would go before the numbers that are
// written.
constexpr const char* kPacked[] = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"};

constexpr const char* kTextureCoordinates = "TEXCOORD_0";

void remove_extensions(Json& object) {
  const auto found = object.find("extensions");
  if (found == object.end() || !found->is_object()) return;
  for (const char* name : kPacked) found->erase(name);
  if (found->empty()) object.erase("extensions");
}

void forget_extensions(Json& json) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    const auto found = json.find(list);
    if (found == json.end() || !found->is_array()) continue;
    for (const char* name : kPacked) {
      found->erase(std::remove(found->begin(), found->end(), Json(name)), found->end());
    }
    if (found->empty()) json.erase(list);
  }
}

// Appends bytes where numbers of any kind may begin, and returns their offset.
size_t append(GltfFile& gltf, std::string_view bytes, std::string& to) {
  constexpr size_t kAlignment = 4;
  to.resize((to.size() + kAlignment - 1) / kAlignment * kAlignment, '\0');
  if (bytes.size() > GltfFile::kFileLimit || to.size() > GltfFile::kFileLimit - bytes.size()) {
    gltf.refuse("has views that overlap, or images, of more than " +
                std::to_string(GltfFile::kFileLimit >> 20) + " MiB in all");
  }
  to += bytes;
  return to.size() - bytes.size();
}

void copy_views(GltfFile& gltf, Json& json, std::string& bytes) {
  const size_t count = gltf.list("bufferViews").size();
  for (size_t i = 0; i < count; ++i) {
    const std::string_view from = gltf.view(i, "the file");
    Json& view = json["bufferViews"][i];
    view["byteOffset"] = append(gltf, from, bytes);
    view["buffer"] = 0;
    remove_extensions(view);
  }
}

// "" for what is none of the two kinds that every reader of glTF knows.
const char* image_type(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG")) return "image/png";
  return bytes.starts_with("\xff\xd8\xff") ? "image/jpeg" : "";
}

void copy_images(GltfFile& gltf, Json& json, GltfSource& source) {
  const size_t count = gltf.list("images").size();
  for (size_t i = 0; i < count; ++i) {
    const std::string uri = GltfFile::text_of(gltf.item("images", i, "the file"), "uri");
    if (uri.empty()) continue;
    const auto read = GltfFile::bytes_of_uri(uri);
    const std::string type = read ? image_type(*read) : "";
    if (type.empty()) {
      source.warnings.push_back(gltf.file().string() + ": image \"" + printable(uri) +
                                "\" is no PNG or JPEG in its folder; it stays a link");
      continue;
    }
    const size_t begin = append(gltf, *read, source.bytes);
    Json& image = json["images"][i];
    image.erase("uri");
    image["mimeType"] = type;
    image["bufferView"] = json["bufferViews"].size();
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", read->size()}});
  }
}

// Reads what each mesh is made of; removes packed copies of it.
void collect_vectors(GltfFile& gltf, Json& json, GltfSource& source) {
  std::set<size_t> known;
  if (!json.contains("meshes")) return;
  for (Json& mesh : json["meshes"]) {
    if (!mesh.is_object() || !mesh.contains("primitives")) continue;
    for (Json& primitive : mesh["primitives"]) {
      if (!primitive.is_object() || !primitive.contains("attributes")) continue;
      remove_extensions(primitive);
      for (const char* name : {"POSITION", "NORMAL", kTextureCoordinates}) {
        const Json& attributes = primitive["attributes"];
        if (!attributes.contains(name)) continue;
        const size_t accessor = gltf.index_of(attributes, name, "attributes");
        if (!known.insert(accessor).second) continue;
        std::vector<double> flat;
        if (name == kTextureCoordinates) {
          if (GltfFile::text_of(gltf.item("accessors", accessor, name), "type") != "VEC2") continue;
          const std::vector<double> pairs = gltf.numbers(accessor, 2);
          for (size_t k = 0; k + 1 < pairs.size(); k += 2) {
            flat.insert(flat.end(), {pairs[k], pairs[k + 1], 0.0});
          }
        } else {
          flat = gltf.numbers(accessor, 3);
        }
        auto& vectors = source.vectors.emplace_back();
        vectors.accessor = static_cast<int>(accessor);
        for (size_t k = 0; k + 2 < flat.size(); k += 3) vectors.values.emplace_back(&flat[k]);
      }
    }
  }
}

GltfSource read_source(const fs::path& file) {
  GltfFile gltf(file);
  GltfSource source;
  try {
    Json json = gltf.json();
    copy_views(gltf, json, source.bytes);
    copy_images(gltf, json, source);
    collect_vectors(gltf, json, source);
    forget_extensions(json);
    json["buffers"] = Json::array({{{"byteLength", source.bytes.size()}}});
    source.json = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  } catch (const Json::exception& error) {
    gltf.refuse("its JSON is not built as glTF has it (" + printable(error.what()) + ")");
  }
  return source;
}

template <typename Archive>
void walk(Archive& archive, GltfSource& source) {
  archive.list(source.json);
  archive.list(source.bytes);
  archive.each(source.vectors, [](Archive& a, GltfSource::Vectors& vectors) {
    a.number(vectors.accessor);
    a.list(vectors.values);
  });
  archive.each(source.warnings, [](Archive& a, std::string& text) { a.list(text); });
}

}  // namespace

bool names_gltf(const fs::path& file) {
  const std::string ending = lower_ending(file);
  return ending == "gltf" || ending == "glb" || ending == "vrm";
}

GltfSource read_gltf_source(const fs::path& file) {
  check_readable(file, GltfFile::kFileLimit);
  Child child(file, "export the character again", [&](std::string_view) {
    GltfSource source = read_source(file);
    Packer packer;
    walk(packer, source);
    return packer.bytes;
  });
  const std::string bytes = child.ask();
  GltfSource source;
  Unpacker unpacker{bytes};
  walk(unpacker, source);
  if (!unpacker.finished()) child.refuse("its reader sent nonsense");
  return source;
}

}  // namespace thew::rig
