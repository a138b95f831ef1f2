// SPDX-License-Identifier: Apache-2.0
//
// Reads glTF 2.0 as a Character. Numbers such as 3.5.2 are sections of its specification.
#include "rig/import/gltf_character.h"

#include <algorithm>
#include <cmath>

#include "rig/import/assimp_scene.h"
#include "rig/import/character_parts.h"
#include "rig/import/gltf_curves.h"
#include "rig/import/gltf_file.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;
using Json = GltfFile::Json;

constexpr size_t kNone = static_cast<size_t>(-1);

std::string nodes_at(size_t node) { return "nodes[" + std::to_string(node) + "]"; }

// 3.5.2: the transform of a node, given as a matrix or as translation, rotation and scale.
Affine local_of(const GltfFile& gltf, const Json& node, const std::string& location) {
  double m[16], t[3] = {0, 0, 0}, r[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
  Affine out = Affine::Identity();
  if (gltf.numbers_of(node, "matrix", 16, location, m)) {
    out.matrix().topRows<3>() = Eigen::Map<Eigen::Matrix4d>(m).topRows<3>();
  } else {
    gltf.numbers_of(node, "translation", 3, location, t);
    gltf.numbers_of(node, "rotation", 4, location, r);
    gltf.numbers_of(node, "scale", 3, location, s);
    const Eigen::Quaterniond turn(r[3], r[0], r[1], r[2]);
    out = join_transform({Vec3(t[0], t[1], t[2]), turn.normalized(), Vec3(s[0], s[1], s[2])});
  }
  if (!out.matrix().allFinite() || out.linear().determinant() == 0.0) {
    const std::string name = GltfFile::text_of(node, "name");
    gltf.refuse("node \"" + (name.empty() ? location : printable(name)) +
                "\" has no sound transform, such as a scale of 0");
  }
  return out;
}

// Which node of the file is which body. Bodies are ordered parents before children.
struct Nodes {
  std::vector<int> body;     // by node; -1: neither in the scene nor a joint
  std::vector<size_t> node;  // by body; kNone: the body that was added above several roots
};

std::vector<size_t> children_of(const GltfFile& gltf, const Json& of, const char* key,
                                const std::string& location) {
  std::vector<size_t> out;
  const auto found = of.find(key);
  if (found == of.end()) return out;
  if (!found->is_array()) gltf.refuse(location + "." + key + " is no list");
  for (const Json& child : *found) {
    out.push_back(gltf.index_of(Json{{"node", child}}, "node", location + "." + key));
    gltf.item("nodes", out.back(), location);
  }
  return out;
}

// The root nodes of the scene, then the roots of joints that are not in the scene.
std::vector<size_t> root_nodes(const GltfFile& gltf) {
  const size_t count = gltf.list("nodes").size();
  std::vector<size_t> parent(count, kNone), roots;
  std::vector<char> is_root(count, 0);
  for (size_t i = 0; i < count; ++i) {
    for (const size_t child :
         children_of(gltf, gltf.item("nodes", i, "the file"), "children", nodes_at(i))) {
      if (parent[child] != kNone) gltf.refuse(nodes_at(child) + " hangs on two nodes");
      parent[child] = i;
    }
  }
  const auto add = [&](size_t node) {
    if (is_root[node]) return;
    is_root[node] = 1;
    roots.push_back(node);
  };
  if (gltf.list("scenes").empty()) {
    for (size_t i = 0; i < count; ++i) {
      if (parent[i] == kNone) add(i);
    }
  } else {
    const size_t scene = gltf.index_or(gltf.json(), "scene", 0, "the file");
    for (const size_t node :
         children_of(gltf, gltf.item("scenes", scene, "the file"), "nodes", "scenes")) {
      add(node);
    }
  }
  for (size_t s = 0; s < gltf.list("skins").size(); ++s) {
    for (size_t node : children_of(gltf, gltf.item("skins", s, "the file"), "joints", "skins")) {
      for (size_t steps = 0; !is_root[node] && parent[node] != kNone; node = parent[node]) {
        if (++steps > count) gltf.refuse(nodes_at(node) + " hangs on itself");
      }
      add(node);
    }
  }
  return roots;
}

Nodes collect_bodies(const GltfFile& gltf, double scale, Character& character) {
  Nodes out;
  out.body.assign(gltf.list("nodes").size(), -1);
  std::vector<std::string> names;
  std::vector<char> has_mesh;
  const auto add = [&](size_t node, int parent, Affine local, const std::string& name, bool mesh) {
    if (parent < 0) local = Eigen::Scaling(scale) * local;
    out.node.push_back(node);
    character.rest.push_back(local);
    character.skeleton.parent.push_back(parent);
    names.push_back(name);
    has_mesh.push_back(mesh ? 1 : 0);
  };
  const std::vector<size_t> roots = root_nodes(gltf);
  if (roots.size() != 1) add(kNone, -1, Affine::Identity(), "ROOT", false);
  const int above = static_cast<int>(out.node.size()) - 1;
  std::vector<std::pair<size_t, int>> open;
  for (size_t i = roots.size(); i-- > 0;) open.emplace_back(roots[i], above);
  while (!open.empty()) {
    const auto [node, parent] = open.back();
    open.pop_back();
    const Json& about = gltf.item("nodes", node, "the file");
    const int body = static_cast<int>(out.node.size());
    if (out.body[node] >= 0) gltf.refuse(nodes_at(node) + " stands in the scene twice");
    if (body > kMaxBodies) {
      gltf.refuse("has more than " + std::to_string(kMaxBodies) + " nodes");
    }
    out.body[node] = body;
    const std::string name = GltfFile::text_of(about, "name");
    add(node, parent, local_of(gltf, about, nodes_at(node)), name.empty() ? nodes_at(node) : name,
        about.contains("mesh"));
    const std::vector<size_t> children = children_of(gltf, about, "children", nodes_at(node));
    for (size_t i = children.size(); i-- > 0;) open.emplace_back(children[i], body);
  }
  name_bodies(names, has_mesh, character.skeleton);
  return out;
}

// A skin: the bodies of its joints, and for each the transform from the mesh into it.
struct Skin {
  std::vector<int> joints;
  std::vector<Affine> into;
  int first = 0;      // index in `joints` of the one nearest to the root
  Affine bind_shape;  // transform of its meshes in the bind pose
};

Skin read_skin(GltfFile& gltf, size_t index, const Nodes& nodes) {
  Skin out;
  const std::string location = "skins[" + std::to_string(index) + "]";
  const Json& skin = gltf.item("skins", index, "the file");
  for (const size_t joint : children_of(gltf, skin, "joints", location)) {
    out.joints.push_back(nodes.body[joint]);
  }
  if (out.joints.empty()) gltf.refuse(location + " has no joints");
  out.into.assign(out.joints.size(), Affine::Identity());
  if (skin.contains("inverseBindMatrices")) {
    const std::vector<double> flat =
        gltf.numbers(gltf.index_of(skin, "inverseBindMatrices", location), 16);
    if (flat.size() < 16 * out.joints.size()) gltf.refuse(location + " has too few bind matrices");
    for (size_t j = 0; j < out.joints.size(); ++j) {
      out.into[j].matrix().topRows<3>() =
          Eigen::Map<const Eigen::Matrix4d>(&flat[16 * j]).topRows<3>();
    }
  }
  for (const Affine& into : out.into) {
    if (into.linear().determinant() == 0.0)
      gltf.refuse(location + " has a bind matrix that is flat");
  }
  out.first =
      static_cast<int>(std::min_element(out.joints.begin(), out.joints.end()) - out.joints.begin());
  return out;
}

// Sets the bind pose of all bodies and the bind shape of each skin. Skins are taken in the order of
// their first joint, the one nearest to the root. A skin is placed by its first joint: as an
// earlier skin has bound it, else by its rest transform relative to the nearest ancestor that is
// bound. Its matrices then give its other joints.
std::vector<Skin> bind_skins(GltfFile& gltf, const Nodes& nodes, Character& character) {
  std::vector<Skin> skins;
  for (size_t i = 0; i < gltf.list("skins").size(); ++i) {
    skins.push_back(read_skin(gltf, i, nodes));
  }
  std::vector<size_t> order(skins.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto first_of = [&](size_t i) { return skins[i].joints[skins[i].first]; };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return first_of(a) < first_of(b); });
  const std::vector<int>& parent = character.skeleton.parent;
  std::vector<char> known(parent.size(), 0);
  const auto fill = [&] {  // bodies of no skin
    for (size_t i = 0; i < parent.size(); ++i) {
      if (known[i]) continue;
      character.bind[i] =
          parent[i] < 0 ? character.rest[i] : character.bind[parent[i]] * character.rest[i];
    }
  };
  character.bind.resize(parent.size());
  for (const size_t i : order) {
    fill();
    Skin& skin = skins[i];
    skin.bind_shape = character.bind[first_of(i)] * skin.into[skin.first];
    for (size_t j = 0; j < skin.joints.size(); ++j) {
      if (known[skin.joints[j]]) continue;
      known[skin.joints[j]] = 1;
      character.bind[skin.joints[j]] = skin.bind_shape * skin.into[j].inverse();
    }
  }
  fill();
  return skins;
}

// The triangles of a primitive: a list, a strip or a fan of them (3.7.2.1).
std::vector<Triangle> triangles_of(GltfFile& gltf, const Json& primitive, size_t vertices,
                                   const std::string& location) {
  const size_t mode = gltf.index_or(primitive, "mode", 4, location);
  std::vector<Triangle> out;
  if (mode < 4 || mode > 6) return out;  // points and lines
  std::vector<std::uint32_t> at;
  if (primitive.contains("indices")) {
    at = gltf.indices(gltf.index_of(primitive, "indices", location), 1);
  } else {
    for (size_t i = 0; i < vertices; ++i) at.push_back(static_cast<std::uint32_t>(i));
  }
  for (const std::uint32_t i : at) {
    if (i < vertices) continue;
    gltf.refuse(location + " names vertex " + std::to_string(i) + " of " +
                std::to_string(vertices));
  }
  for (size_t i = 0; i + 2 < at.size(); i += mode == 4 ? 3 : 1) {
    const bool odd = mode == 5 && i % 2 == 1;
    const size_t a = mode == 6 ? 0 : i, b = i + 1 + (odd ? 1 : 0), c = i + 2 - (odd ? 1 : 0);
    out.push_back({static_cast<int>(at[a]), static_cast<int>(at[b]), static_cast<int>(at[c])});
  }
  return out;
}

// Appends the weights of JOINTS_n and WEIGHTS_n, which have four for each vertex. Weights of one
// joint are added up.
void append_weights(GltfFile& gltf, const Json& attributes, const Skin& skin, int first, int link,
                    const std::string& location, Influences& influences) {
  const size_t count = influences.size() - first;
  for (int set = 0;; ++set) {
    const std::string joints = "JOINTS_" + std::to_string(set),
                      weights = "WEIGHTS_" + std::to_string(set);
    if (!attributes.contains(joints) || !attributes.contains(weights)) return;
    const auto at = gltf.indices(gltf.index_of(attributes, joints.c_str(), location), 4);
    const auto share = gltf.numbers(gltf.index_of(attributes, weights.c_str(), location), 4, true);
    if (at.size() < 4 * count || share.size() < 4 * count) {
      gltf.refuse(location + " has fewer weights than vertices");
    }
    for (size_t i = 0; i < 4 * count; ++i) {
      if (share[i] == 0.0) continue;
      if (at[i] >= skin.joints.size() || !(share[i] > 0.0 && share[i] < 1e6)) {
        gltf.refuse(location + " has weight " + number_text(share[i]) + " of joint " +
                    std::to_string(at[i]) + " of " + std::to_string(skin.joints.size()) +
                    " on vertex " + std::to_string(i / 4));
      }
      auto& of_vertex = influences[first + i / 4];
      const int joint = link + static_cast<int>(at[i]);
      const auto same = std::find_if(of_vertex.begin(), of_vertex.end(),
                                     [&](const auto& one) { return one.first == joint; });
      if (same == of_vertex.end()) {
        of_vertex.emplace_back(joint, share[i]);
      } else {
        same->second += share[i];
      }
    }
  }
}

// 3.7.3.3: a skinned mesh is placed by joints, inverse bind matrices and weights alone, and the
// transform of its own node is to be ignored. That matters, because Blender puts the mesh under its
// armature, which may have any scale and rotation.
void append_primitive(GltfFile& gltf, const Json& primitive, const MeshPart& about, int body,
                      const Skin* skin, const std::string& location, Influences& influences,
                      Character& character) {
  const auto found = primitive.find("attributes");
  if (found == primitive.end() || !found->contains("POSITION")) return;
  const Json& attributes = *found;
  if (primitive.contains("extensions") &&
      primitive["extensions"].contains("KHR_draco_mesh_compression") &&
      !gltf.item("accessors", gltf.index_of(attributes, "POSITION", location), location)
           .contains("bufferView")) {
    gltf.refuse("is compressed (KHR_draco_mesh_compression), which Thew does not read",
                GltfFile::kUncompressed);
  }
  if (!attributes.contains("JOINTS_0") || !attributes.contains("WEIGHTS_0")) skin = nullptr;
  const std::vector<double> flat = gltf.numbers(gltf.index_of(attributes, "POSITION", location), 3);
  std::vector<Vec3> vertices(flat.size() / 3);
  for (size_t i = 0; i < vertices.size(); ++i) vertices[i] = Vec3(&flat[3 * i]);
  const int first = append_part(
      gltf.file(), about, vertices, triangles_of(gltf, primitive, vertices.size(), location),
      skin ? skin->bind_shape : character.bind[body], influences, character);
  if (skin) {
    const int link = static_cast<int>(character.skin.links.size());
    const Affine to_mesh = skin->bind_shape.inverse();
    for (size_t j = 0; j < skin->joints.size(); ++j) {
      character.skin.links.push_back({skin->joints[j], skin->into[j] * to_mesh});
    }
    append_weights(gltf, attributes, *skin, first, link, location, influences);
    body = skin->joints[skin->first];
  }
  attach_unweighted(gltf.file(), first, body, character.bind[body], skin != nullptr, influences,
                    character);
}

void collect_meshes(GltfFile& gltf, const Nodes& nodes, const std::vector<Skin>& skins,
                    Character& character) {
  Influences influences;
  for (size_t body = 0; body < nodes.node.size(); ++body) {
    if (nodes.node[body] == kNone) continue;
    const std::string from = nodes_at(nodes.node[body]);
    const Json& node = gltf.list("nodes")[nodes.node[body]];
    if (!node.contains("mesh")) continue;
    const size_t index = gltf.index_of(node, "mesh", from);
    const Json& mesh = gltf.item("meshes", index, from);
    const Skin* skin = nullptr;
    if (node.contains("skin")) {
      const size_t of = gltf.index_of(node, "skin", from);
      gltf.item("skins", of, from);
      skin = &skins[of];
    }
    MeshPart part;
    part.node = GltfFile::text_of(node, "name");
    part.mesh = GltfFile::text_of(mesh, "name");
    if (part.mesh.empty()) part.mesh = character.skeleton.body_names[body];
    part.mesh_index = static_cast<int>(index);
    part.node_index = static_cast<int>(nodes.node[body]);
    const auto primitives = mesh.find("primitives");
    if (primitives == mesh.end() || !primitives->is_array()) continue;
    for (size_t p = 0; p < primitives->size(); ++p) {
      const std::string location =
          "meshes[" + std::to_string(index) + "].primitives[" + std::to_string(p) + "]";
      const Json& primitive = (*primitives)[p];
      if (!primitive.is_object()) gltf.refuse(location + " is no object");
      part.primitive = static_cast<int>(p);
      part.material.clear();
      if (primitive.contains("material")) {
        part.material = GltfFile::text_of(
            gltf.item("materials", gltf.index_of(primitive, "material", location), location),
            "name");
      }
      append_primitive(gltf, primitive, part, static_cast<int>(body), skin, location, influences,
                       character);
    }
  }
  leave_out_coarser(gltf.file(), influences, character);
  put_weights(gltf.file(), influences, character);
}

// The bones that VRM names: VRM 1.0 has an object by name, VRM 0.x a list.
void collect_humanoid(const GltfFile& gltf, const Nodes& nodes, Character& character) {
  const auto bones_in = [&](const char* extension) -> const Json* {
    const Json* at = &gltf.json();
    for (const char* key : {"extensions", extension, "humanoid", "humanBones"}) {
      const auto found = at->find(key);
      if (found == at->end()) return nullptr;
      at = &*found;
    }
    return at;
  };
  const auto add = [&](const std::string& bone, const Json& of) {
    if (bone.empty() || !of.is_object() || !of.contains("node")) return;
    const size_t node = gltf.index_of(of, "node", "humanBones");
    gltf.item("nodes", node, "humanBones");
    if (nodes.body[node] >= 0) character.humanoid.push_back({bone, nodes.body[node]});
  };
  const Json* bones = bones_in("VRMC_vrm");
  if (bones && bones->is_object()) {
    for (const auto& [bone, of] : bones->items()) add(bone, of);
    return;
  }
  bones = bones_in("VRM");
  if (!bones || !bones->is_array()) return;
  for (const Json& of : *bones) {
    if (of.is_object()) add(GltfFile::text_of(of, "bone"), of);
  }
}

}  // namespace

Character read_gltf_character(const fs::path& file, double scale, bool with_mesh) {
  GltfFile gltf(file);
  Character character;
  try {
    const Nodes nodes = collect_bodies(gltf, scale, character);
    for (const size_t node : nodes.node) {
      character.nodes.push_back(node == kNone ? -1 : static_cast<int>(node));
    }
    const std::vector<Skin> skins = bind_skins(gltf, nodes, character);
    collect_meshes(gltf, nodes, skins, character);
    if (with_mesh && character.parts.empty()) gltf.refuse("has no mesh");
    read_gltf_animations(gltf, nodes.body, scale, character);
    collect_humanoid(gltf, nodes, character);
    character.files = gltf.files_named();
  } catch (const Json::exception& error) {
    gltf.refuse("its JSON is not built as glTF has it (" + printable(error.what()) + ")");
  }
  if (with_mesh) note_size(file, character);
  return character;
}

}  // namespace thew::rig
