// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json.hpp>

#include "rig/character.h"
#include "tests/unit/tools/export/export.h"
#include "tools/export/shot.h"

namespace thew::tests {

using nlohmann::json;

struct Glb {
  json doc;
  std::string numbers;

  ByteReader at_view(const json& view_number) const {
    return {numbers, doc["bufferViews"][view_number.get<std::size_t>()]["byteOffset"]};
  }
  const json& accessor(const json& number) const {
    return doc["accessors"][number.get<std::size_t>()];
  }
  static std::size_t width_of(const json& accessor) {
    const std::map<std::string, std::size_t> widths = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    return widths.at(accessor["type"]);
  }
  /// Of a dense accessor, one item after another.
  template <typename T>
  std::vector<T> items(const json& number) const {
    const json& of = accessor(number);
    const json& view = doc["bufferViews"][of["bufferView"].get<std::size_t>()];
    const std::size_t width = width_of(of), stride = view.value("byteStride", width * sizeof(T));
    std::vector<T> values;
    for (std::size_t i = 0; i < of["count"].get<std::size_t>(); ++i) {
      ByteReader in = at_view(of["bufferView"]);
      in.at += of.value("byteOffset", std::size_t{0}) + i * stride;
      for (std::size_t k = 0; k < width; ++k) values.push_back(in.take<T>());
    }
    return values;
  }
  std::vector<float> floats(const json& accessor_number) const {
    const json& accessor = this->accessor(accessor_number);
    const std::size_t width = width_of(accessor);
    std::vector<float> values(accessor["count"].get<std::size_t>() * width);
    if (accessor.contains("sparse")) {
      const json& sparse = accessor["sparse"];
      ByteReader indices = at_view(sparse["indices"]["bufferView"]),
                 read = at_view(sparse["values"]["bufferView"]);
      EXPECT_EQ(sparse["indices"]["componentType"], 5125);
      for (std::size_t i = 0; i < sparse["count"].get<std::size_t>(); ++i) {
        const auto at = indices.take<std::uint32_t>();
        for (std::size_t k = 0; k < width; ++k) values.at(at * width + k) = read.take<float>();
      }
      return values;
    }
    if (accessor["componentType"] == 5126) return items<float>(accessor_number);
    EXPECT_EQ(accessor["normalized"], true);
    const bool bytes = accessor["componentType"] == 5120;
    EXPECT_TRUE(bytes || accessor["componentType"] == 5122);
    std::size_t i = 0;
    if (bytes) {
      for (const auto step : items<std::int8_t>(accessor_number)) values[i++] = step / 127.0f;
    } else {
      for (const auto step : items<std::int16_t>(accessor_number)) values[i++] = step / 32767.0f;
    }
    return values;
  }
};

inline Glb read_glb(const std::filesystem::path& file) {
  ByteReader in{bytes_of(file)};
  EXPECT_EQ(in.bytes.substr(0, 4), "glTF");
  in.at = 4;
  EXPECT_EQ(in.take<std::uint32_t>(), 2u);
  EXPECT_EQ(in.take<std::uint32_t>(), in.bytes.size());
  const std::uint32_t length = in.take<std::uint32_t>();
  EXPECT_EQ(in.bytes.substr(in.at, 4), "JSON");
  Glb glb;
  glb.doc = json::parse(in.bytes.substr(in.at + 4, length));
  in.at += 4 + length;
  EXPECT_EQ(in.take<std::uint32_t>(), glb.doc["buffers"][0]["byteLength"].get<std::uint32_t>());
  glb.numbers = in.bytes.substr(in.at + 4);
  EXPECT_EQ(in.at % 4, 0u);
  return glb;
}

/// What a viewer makes of a file at a key of its first animation: nodes, morph targets, skins.
class GlbPlayer {
 public:
  GlbPlayer(const Glb& glb, std::size_t key) : glb_(glb), key_(key) {
    const json& nodes = glb.doc["nodes"];
    world_.resize(nodes.size());
    for (const json& node : glb.doc["scenes"][0]["nodes"]) place(node, Affine::Identity());
  }

  /// Positions and normals of one primitive in the world; a file without normals gives none.
  Shape shape(std::size_t node, std::size_t primitive) const {
    const json& of = glb_.doc["nodes"][node];
    const json& mesh = glb_.doc["meshes"][of["mesh"].get<std::size_t>()];
    const json& part = mesh["primitives"][primitive];
    const json& attributes = part["attributes"];
    const std::vector<float> weights = weights_of(node, mesh);
    const std::vector<Affine> carried = carries(node, attributes);
    Shape shape{morphed(part, "POSITION", weights), {}};
    if (attributes.contains("NORMAL")) shape.normals = morphed(part, "NORMAL", weights);
    for (std::size_t v = 0; v < shape.positions.size(); ++v) {
      const Affine& carry = carried.size() == 1 ? carried[0] : carried[v];
      shape.positions[v] = carry * shape.positions[v];
      if (shape.normals.empty()) continue;
      shape.normals[v] = (carry.linear().inverse().transpose() * shape.normals[v]).normalized();
    }
    return shape;
  }

 private:
  std::vector<float> keys(std::size_t node, const char* path, std::size_t width) const {
    const json& animation = glb_.doc["animations"][0];
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      const std::vector<float> all = glb_.floats(sampler["output"]);
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(key_ * width);
      return {begin, begin + static_cast<std::ptrdiff_t>(width)};
    }
    return {};
  }

  void place(std::size_t number, const Affine& parent) {
    const json& node = glb_.doc["nodes"][number];
    EXPECT_FALSE(node.contains("matrix"));
    const auto part = [&](const char* path, std::vector<float> otherwise) {
      const std::vector<float> keyed = keys(number, path, otherwise.size());
      return keyed.empty() ? node.value(path, otherwise) : keyed;
    };
    const auto t = part("translation", {0, 0, 0}), r = part("rotation", {0, 0, 0, 1}),
               s = part("scale", {1, 1, 1});
    world_[number] = parent * Eigen::Translation3d(t[0], t[1], t[2]) *
                     Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized() *
                     Eigen::Scaling(double{s[0]}, double{s[1]}, double{s[2]});
    for (const json& child : node.value("children", json::array())) place(child, world_[number]);
  }

  std::vector<float> weights_of(std::size_t node, const json& mesh) const {
    const json& first = mesh["primitives"][0];
    const std::size_t count = first.contains("targets") ? first["targets"].size() : 0;
    const std::vector<float> keyed = keys(node, "weights", count);
    return keyed.empty() ? mesh.value("weights", std::vector<float>(count, 0.0f)) : keyed;
  }

  std::vector<Vec3> morphed(const json& part, const char* name,
                            const std::vector<float>& weights) const {
    const auto read = [&](const json& accessor) {
      const std::vector<float> flat = glb_.floats(accessor);
      std::vector<Vec3> out;
      for (std::size_t k = 0; k < flat.size(); k += 3) {
        out.emplace_back(flat[k], flat[k + 1], flat[k + 2]);
      }
      return out;
    };
    std::vector<Vec3> sum = read(part["attributes"][name]);
    for (std::size_t t = 0; t < weights.size(); ++t) {
      if (weights[t] == 0.0f || !part["targets"][t].contains(name)) continue;
      const std::vector<Vec3> target = read(part["targets"][t][name]);
      for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += double{weights[t]} * target[v];
    }
    return sum;
  }

  // By vertex, or one for all of a mesh that hangs on its node.
  std::vector<Affine> carries(std::size_t node, const json& attributes) const {
    const json& of = glb_.doc["nodes"][node];
    if (!of.contains("skin")) return {world_[node]};
    const json& skin = glb_.doc["skins"][of["skin"].get<std::size_t>()];
    const auto joints = glb_.items<std::uint8_t>(attributes["JOINTS_0"]);
    const auto weights = glb_.floats(attributes["WEIGHTS_0"]),
               into = glb_.floats(skin["inverseBindMatrices"]);
    std::vector<Affine> out;
    for (std::size_t first = 0; first < joints.size(); first += 4) {
      Eigen::Matrix4d blend = Eigen::Matrix4d::Zero();
      for (std::size_t k = first; k < first + 4; ++k) {
        const Eigen::Matrix4f bind = Eigen::Map<const Eigen::Matrix4f>(&into[16 * joints[k]]);
        blend += double{weights[k]} *
                 world_[skin["joints"][joints[k]].get<std::size_t>()].matrix() *
                 bind.cast<double>();
      }
      out.emplace_back(blend / blend(3, 3));
    }
    return out;
  }

  const Glb& glb_;
  std::size_t key_;
  std::vector<Affine> world_;
};

}  // namespace thew::tests
