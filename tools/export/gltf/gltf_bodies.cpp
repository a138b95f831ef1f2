// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/gltf_bodies.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

// Where the file has a node, as it is there before any animation, and what it hangs on there.
struct InFile {
  int parent;
  LocalTransform rest;
};
InFile in_file(const Character& character, int body) {
  for (const Character::Twin& twin : character.twins) {
    if (twin.body == body) return {twin.parent_in_file, split_transform(twin.rest_in_file)};
  }
  return {character.skeleton.parent[body], split_transform(character.rest[body])};
}

void put_floats_of(const Vec3& value, std::vector<float>& to) {
  for (const double x : value) to.push_back(static_cast<float>(x));
}

// The keys of one body, and its local transforms as they are read from the file.
struct NodeKeys {
  std::vector<float> translation, rotation, scale;
  std::vector<Affine> read;
};

// Components that stay as the file has them at rest get no keys.
NodeKeys keys_of(const CharacterSkin& skin, int body) {
  constexpr double kSame = 1e-6;  // of a unit's length, of rotations and scales
  const InFile in = in_file(skin.character, body);
  const LocalTransform& rest = in.rest;
  std::vector<LocalTransform> locals;
  bool moves = false, turns = false, stretches = false;
  Eigen::Quaterniond last = rest.rotation;
  for (const std::vector<Affine>& world : skin.bodies) {
    LocalTransform local =
        split_transform(in.parent < 0 ? world[body] : world[in.parent].inverse() * world[body]);
    if (local.rotation.dot(last) < 0.0) local.rotation.coeffs() = -local.rotation.coeffs();
    last = local.rotation;
    moves |= (local.translation - rest.translation).norm() > kSame * 0.1;
    turns |= (local.rotation.coeffs() - rest.rotation.coeffs()).norm() > kSame;
    stretches |= (local.scale - rest.scale).norm() > kSame;
    locals.push_back(local);
  }
  NodeKeys keys;
  for (const LocalTransform& local : locals) {
    LocalTransform read = rest;
    if (moves) {
      put_floats_of(local.translation, keys.translation);
      read.translation = as_float32({local.translation})[0];
    }
    if (turns) {
      for (int k = 0; k < 4; ++k) {
        keys.rotation.push_back(static_cast<float>(local.rotation.coeffs()[k]));
        read.rotation.coeffs()[k] = as_float32(local.rotation.coeffs()[k]);
      }
    }
    if (stretches) {
      put_floats_of(local.scale, keys.scale);
      read.scale = as_float32({local.scale})[0];
    }
    keys.read.push_back(join_transform(read));
  }
  return keys;
}

// A node that moves is not to have a matrix.
void separate_matrix(const LocalTransform& rest, ordered_json& node) {
  if (!node.contains("matrix")) return;
  node.erase("matrix");
  node["translation"] = {rest.translation.x(), rest.translation.y(), rest.translation.z()};
  const Eigen::Vector4d turn = rest.rotation.coeffs();
  node["rotation"] = {turn[0], turn[1], turn[2], turn[3]};
  node["scale"] = {rest.scale.x(), rest.scale.y(), rest.scale.z()};
}

}  // namespace

World animate_bodies(const CharacterSkin& skin, std::size_t times, Glb& glb,
                     ordered_json& animation) {
  const Character& character = skin.character;
  World read(skin.bodies.size(), std::vector<Affine>(character.bind.size()));
  for (int body = 0; body < character.skeleton.size(); ++body) {
    const NodeKeys keys = keys_of(skin, body);
    const int node = character.nodes.at(body);
    const InFile in = in_file(character, body);
    for (std::size_t f = 0; f < read.size(); ++f) {
      read[f][body] = in.parent < 0 ? keys.read[f] : read[f][in.parent] * keys.read[f];
    }
    if (node < 0) continue;
    const auto add = [&](const char* path, const std::vector<float>& values, std::size_t width) {
      if (values.empty()) return;
      separate_matrix(in.rest, glb.json["nodes"].at(node));
      add_channel(animation, static_cast<std::size_t>(node), path, times,
                  add_keys(glb, values, width));
    };
    add("translation", keys.translation, 3);
    add("rotation", keys.rotation, 4);
    add("scale", keys.scale, 3);
  }
  return read;
}

}  // namespace thew::tools
