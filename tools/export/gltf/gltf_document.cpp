// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/gltf_document.h"

#include <algorithm>
#include <functional>

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

// Calls `visit` with each member of this name of the objects of a list; `of` may be missing.
void each_in(ordered_json& of, const char* list, const std::function<void(ordered_json&)>& visit) {
  const auto found = of.find(list);
  if (found == of.end()) return;
  for (ordered_json& item : *found) visit(item);
}

using Visit = std::function<void(ordered_json&)>;

void visit_member(ordered_json& of, const char* key, const Visit& visit) {
  const auto found = of.find(key);
  if (found != of.end()) visit(*found);
}

void visit_values(ordered_json& of, const char* key, const Visit& visit) {
  visit_member(of, key, [&](ordered_json& values) {
    for (ordered_json& value : values) visit(value);
  });
}

// All numbers of accessors: those of the core of glTF, and of EXT_mesh_gpu_instancing, the one
// extension of the Khronos group's that has any.
void visit_accessors(ordered_json& json, const Visit& visit) {
  each_in(json, "meshes", [&](ordered_json& mesh) {
    each_in(mesh, "primitives", [&](ordered_json& primitive) {
      visit_values(primitive, "attributes", visit);
      visit_member(primitive, "indices", visit);
      visit_member(primitive, "targets", [&](ordered_json& targets) {
        for (ordered_json& target : targets) {
          for (ordered_json& accessor : target) visit(accessor);
        }
      });
    });
  });
  each_in(json, "nodes", [&](ordered_json& node) {
    visit_member(node, "extensions", [&](ordered_json& extensions) {
      visit_member(extensions, "EXT_mesh_gpu_instancing",
                   [&](ordered_json& instances) { visit_values(instances, "attributes", visit); });
    });
  });
  each_in(json, "skins",
          [&](ordered_json& skin) { visit_member(skin, "inverseBindMatrices", visit); });
  each_in(json, "animations", [&](ordered_json& animation) {
    each_in(animation, "samplers", [&](ordered_json& sampler) {
      visit_member(sampler, "input", visit);
      visit_member(sampler, "output", visit);
    });
  });
}

// All numbers of views: what refers to one calls it so, extensions too.
void visit_views(ordered_json& json, const Visit& visit) {
  if (!json.is_structured()) return;
  for (auto item = json.begin(); item != json.end(); ++item) {
    if (json.is_object() && item.key() == "bufferView") {
      visit(*item);
    } else {
      visit_views(*item, visit);
    }
  }
}

using Visitor = void (*)(ordered_json&, const Visit&);

// Removes the items of a list to which nothing points any more, and counts the others anew.
void remove_unused(ordered_json& json, const char* list, Visitor visit_all) {
  ordered_json& items = json.at(list);
  std::vector<std::size_t> place(items.size(), items.size());
  visit_all(json, [&](ordered_json& number) { place.at(number.get<std::size_t>()) = 0; });
  ordered_json kept = ordered_json::array();
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (place[i] != 0) continue;
    place[i] = kept.size();
    kept.push_back(items[i]);
  }
  items = kept;
  visit_all(json, [&](ordered_json& number) { number = place[number.get<std::size_t>()]; });
}

ordered_json& mesh_of(Glb& glb, int node) {
  return glb.json.at("meshes").at(glb.json.at("nodes").at(node).at("mesh").get<std::size_t>());
}

}  // namespace

ordered_json& object_at(ordered_json& parent, const char* key) {
  if (!parent.contains(key) || !parent[key].is_object()) parent[key] = ordered_json::object();
  return parent[key];
}

ordered_json& list_at(ordered_json& parent, const char* key) {
  if (!parent.contains(key) || !parent[key].is_array()) parent[key] = ordered_json::array();
  return parent[key];
}

Glb open_document(const GltfSource& source) {
  Glb glb{ordered_json::parse(source.json), source.bytes};
  for (const char* list : {"bufferViews", "accessors", "animations"}) list_at(glb.json, list);
  return glb;
}

void separate_meshes(Glb& glb, const std::vector<int>& nodes) {
  std::vector<std::size_t> users(glb.json.at("meshes").size(), 0);
  for (const ordered_json& node : glb.json.at("nodes")) {
    if (node.contains("mesh")) ++users.at(node["mesh"].get<std::size_t>());
  }
  for (const int node : nodes) {
    ordered_json& mesh = glb.json["nodes"][node].at("mesh");
    std::size_t& shared = users.at(mesh.get<std::size_t>());
    if (shared < 2) continue;
    --shared;
    const ordered_json copy = mesh_of(glb, node);
    mesh = glb.json["meshes"].size();
    glb.json["meshes"].push_back(copy);
  }
}

void make_static(Glb& glb, int node) {
  glb.json["nodes"][node].erase("skin");
  glb.json["nodes"][node].erase("weights");
  ordered_json& mesh = mesh_of(glb, node);
  mesh.erase("weights");
  if (mesh.contains("extras") && mesh["extras"].is_object()) mesh["extras"].erase("targetNames");
  for (ordered_json& primitive : mesh.at("primitives")) {
    primitive.erase("targets");
    ordered_json kept = ordered_json::object();
    for (const auto& [name, accessor] : primitive.at("attributes").items()) {
      const bool of_bind =
          name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_") || name == "TANGENT";
      if (!of_bind) kept[name] = accessor;
    }
    primitive["attributes"] = kept;
  }
}

void remove_unused_skins(Glb& glb) {
  if (!glb.json.contains("skins")) return;
  ordered_json kept = ordered_json::array();
  std::vector<int> place(glb.json["skins"].size(), -1);
  for (ordered_json& node : glb.json.at("nodes")) {
    if (!node.contains("skin")) continue;
    const std::size_t skin = node["skin"].get<std::size_t>();
    if (place.at(skin) < 0) {
      place[skin] = static_cast<int>(kept.size());
      kept.push_back(glb.json["skins"][skin]);
    }
    node["skin"] = place[skin];
  }
  glb.json["skins"] = kept;
  if (kept.empty()) glb.json.erase("skins");
}

void remove_weight_channels(Glb& glb, const std::vector<int>& nodes) {
  for (ordered_json& animation : glb.json["animations"]) {
    ordered_json kept = ordered_json::array();
    for (const ordered_json& channel : animation.at("channels")) {
      const ordered_json& target = channel.at("target");
      const bool removed =
          target.value("path", "") == "weights" &&
          std::find(nodes.begin(), nodes.end(), target.value("node", -1)) != nodes.end();
      if (!removed) kept.push_back(channel);
    }
    animation["channels"] = kept;
  }
  // glTF has no animation without channels.
  ordered_json moving = ordered_json::array();
  for (const ordered_json& animation : glb.json["animations"]) {
    if (!animation["channels"].empty()) moving.push_back(animation);
  }
  glb.json["animations"] = moving;
}

void drop_unused(Glb& glb) {
  remove_unused(glb.json, "accessors", visit_accessors);
  remove_unused(glb.json, "bufferViews", visit_views);
  std::string bytes;
  for (ordered_json& view : glb.json["bufferViews"]) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    const auto begin = view.at("byteOffset").get<std::size_t>();
    view["byteOffset"] = bytes.size();
    bytes.append(glb.bytes, begin, view.at("byteLength").get<std::size_t>());
  }
  glb.bytes.swap(bytes);
}

std::size_t count_targets(const ordered_json& mesh) {
  const ordered_json& first = mesh.at("primitives").at(0);
  return first.contains("targets") ? first["targets"].size() : 0;
}

}  // namespace thew::tools
