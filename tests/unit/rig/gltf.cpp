// SPDX-License-Identifier: Apache-2.0
//
// The made-up figure, written in the other forms that glTF 2.0 allows, stays the same character.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "rig/import/character_import.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string word(size_t value) {
  std::string out;
  for (int k = 0; k < 4; ++k) out.push_back(static_cast<char>(value >> 8 * k & 255));
  return out;
}

class GltfFigure : public TempFolder {
 protected:
  GltfFigure() : plain(import_character(kFigure)) {
    std::ifstream in(kFigure);
    json = Json::parse(in);
    const std::string uri = json["buffers"][0]["uri"];
    unsigned value = 0;
    int bits = 0;
    for (size_t i = uri.find(',') + 1; i < uri.size() && uri[i] != '='; ++i) {
      const auto digit = static_cast<unsigned>(std::string_view(kDigits).find(uri[i]));
      value = value << 6 | digit;
      bits += 6;
      if (bits < 8) continue;
      bits -= 8;
      bytes.push_back(static_cast<char>(value >> bits & 255));
    }
  }

  // The accessors of the figure itself come before these and are not changed.
  template <typename T>
  int add_view(const std::vector<T>& values) {
    bytes.append(bytes.size() % 4 == 0 ? 0 : 4 - bytes.size() % 4, '\0');
    json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }
  template <typename T>
  int add(const std::vector<T>& values, const char* type, int kind, int width) {
    const int view = add_view(values);
    json["accessors"].push_back({{"bufferView", view},
                                 {"type", type},
                                 {"componentType", kind},
                                 {"count", values.size() / width}});
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  // Floats, or bytes, of one of the figure's own accessors.
  template <typename T>
  std::vector<T> values(int accessor) const {
    const Json& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<int>()];
    const size_t length = view["byteLength"];
    std::vector<T> out(length / sizeof(T));
    std::memcpy(out.data(), bytes.data() + view["byteOffset"].get<size_t>(), length);
    return out;
  }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  Json& attributes() { return primitive()["attributes"]; }

  std::string as_glb() const {
    Json of = json;
    of["buffers"][0] = {{"byteLength", bytes.size()}};
    std::string text = of.dump(), data = bytes;
    text.append((4 - text.size() % 4) % 4, ' ');
    data.append((4 - data.size() % 4) % 4, '\0');
    const size_t size = 12 + 8 + text.size() + 8 + data.size();
    return "glTF" + word(2) + word(size) + word(text.size()) + "JSON" + text + word(data.size()) +
           std::string("BIN\0", 4) + data;
  }
  Character read(const char* name = "x.glb") const {
    return import_character(write(name, as_glb()));
  }
  std::string refusal(const char* name = "x.glb") const {
    return input_error([&] { read(name); });
  }

  // Largest distance (m) of skeleton, skin in the bind pose and skin in motion from those of the
  // plain figure, vertex by vertex; `of` gives the vertices of the plain one.
  double distance_from_plain(const Character& other, const std::vector<int>& of = {}) const {
    double worst = 0.0;
    for (int b = 0; b < plain.skeleton.size(); ++b) {
      const std::string& name = plain.skeleton.body_names[b];
      const int same = find_body(other.skeleton, name);
      if (name == "Figure" || name == "ROOT") continue;
      if (same < 0) return 1e3;
      worst = std::max(worst, (plain.bind[b].matrix() - other.bind[same].matrix()).norm());
    }
    Points x, y;
    for (const double time : {-1.0, 0.7, 1.6}) {
      pose(plain, time, x);
      pose(other, time, y);
      if (of.empty() ? x.size() != y.size() : of.size() != y.size()) return 1e3;
      for (size_t i = 0; i < y.size(); ++i) {
        worst = std::max(worst, (to_vec(x[of.empty() ? i : of[i]]) - to_vec(y[i])).norm());
      }
    }
    return worst;
  }
  static void pose(const Character& character, double time, Points& x) {
    std::vector<Affine> world = character.bind;
    if (time >= 0.0) animated_bodies(character, character.animations[0], time, world);
    skin_vertices(character.skin, character.mesh, world, x);
  }

  inline static const fs::path kFigure =
      fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf";
  const Character plain;
  Json json;
  std::string bytes;
};

TEST_F(GltfFigure, InEveryContainer) {
  EXPECT_EQ(distance_from_plain(read()), 0.0);
  EXPECT_EQ(distance_from_plain(read("x.vrm")), 0.0);
  // A chunk of another kind between, and one after.
  std::string other = as_glb();
  const size_t json_end = 20 + static_cast<unsigned char>(other[12]) +
                          256 * static_cast<unsigned char>(other[13]) +
                          65536 * static_cast<unsigned char>(other[14]);
  other.insert(json_end, word(4) + "XTRA" + "abcd");
  EXPECT_EQ(distance_from_plain(import_character(write("y.glb", other + word(0) + "ZZZZ"))), 0.0);
  // Beside the file, with a blank in its name.
  write("my mesh.bin", bytes);
  json["buffers"][0]["uri"] = "my%20mesh.bin";
  EXPECT_EQ(distance_from_plain(import_character(write("z.gltf", json.dump()))), 0.0);
}

TEST_F(GltfFigure, ItsPartsAreNamed) {
  json["meshes"][0]["name"] = "body";
  json["materials"] = {{{"name", "skin"}}};
  primitive()["material"] = 0;
  const Character character = read();
  ASSERT_EQ(character.parts.size(), 1u);
  EXPECT_EQ(character.parts[0].mesh, "body");
  EXPECT_EQ(character.parts[0].node, "Figure");
  EXPECT_EQ(character.parts[0].material, "skin");
  EXPECT_EQ(character.parts[0].mesh_index, 0);
  EXPECT_EQ(character.parts[0].primitive, 0);
}

TEST_F(GltfFigure, SparseOverZerosAndOverItself) {
  const int position = attributes()["POSITION"];
  const auto places = values<float>(position);
  const size_t count = places.size() / 3;
  std::vector<std::uint16_t> all(count);
  for (size_t i = 0; i < count; ++i) all[i] = static_cast<std::uint16_t>(i);
  const Json part = {{"count", count},
                     {"indices", {{"bufferView", add_view(all)}, {"componentType", 5123}}},
                     {"values", {{"bufferView", json["accessors"][position]["bufferView"]}}}};
  const Json before = json;
  json["accessors"][position].erase("bufferView");
  json["accessors"][position]["sparse"] = part;
  EXPECT_EQ(distance_from_plain(read()), 0.0);
  // Every third vertex is wrong underneath.
  json = before;
  auto wrong = places;
  std::vector<std::uint8_t> some;
  std::vector<float> right;
  for (size_t i = 0; i < 80; ++i) {
    wrong[9 * i] += 7.0f;
    some.push_back(static_cast<std::uint8_t>(3 * i));
    right.insert(right.end(), places.begin() + 9 * i, places.begin() + 9 * i + 3);
  }
  attributes()["POSITION"] = add(wrong, "VEC3", 5126, 3);
  EXPECT_GT(distance_from_plain(read()), 1.0);
  json["accessors"].back()["sparse"] = {
      {"count", 80},
      {"indices", {{"bufferView", add_view(some)}, {"componentType", 5121}}},
      {"values", {{"bufferView", add_view(right)}}}};
  EXPECT_EQ(distance_from_plain(read()), 0.0);
}

// As writers that pack a file leave out what is 0 throughout.
TEST_F(GltfFigure, ZerosThatNoBytesHold) {
  const size_t count = values<float>(attributes()["POSITION"]).size() / 3;
  const auto add_zeros = [&](int kind) {
    json["accessors"].push_back({{"componentType", kind}, {"count", count}, {"type", "VEC4"}});
    return json["accessors"].size() - 1;
  };
  attributes()["JOINTS_1"] = add_zeros(5123);
  attributes()["WEIGHTS_1"] = add_zeros(5126);
  EXPECT_EQ(distance_from_plain(read()), 0.0);
}

// Normalised integers of 8 and 16 bits, which the reader converts exactly.
TEST_F(GltfFigure, WeightsAsIntegers) {
  const auto weights = values<float>(attributes()["WEIGHTS_0"]);
  const auto compare = [&](const auto& rounded, double largest) {
    const Character character = read();
    EXPECT_TRUE(character.warnings.empty());
    double rounding = 0.0;
    for (size_t i = 0; i < weights.size() / 4; ++i) {
      int at = character.skin.first[i];
      double sum = 0.0;
      for (size_t k = 4 * i; k < 4 * i + 4; ++k) sum += rounded[k] / largest;
      for (size_t k = 4 * i; k < 4 * i + 4; ++k) {
        rounding = std::max(rounding, std::abs(rounded[k] / largest - weights[k]));
        if (rounded[k] == 0) continue;
        ASSERT_DOUBLE_EQ(character.skin.weight[at++], rounded[k] / largest / sum) << i;
      }
      ASSERT_EQ(at, character.skin.first[i + 1]) << i;
    }
    EXPECT_GT(rounding, 0.1 / largest);  // not the floats
  };
  std::vector<std::uint8_t> small;
  std::vector<std::uint16_t> large;
  for (const float w : weights) {
    small.push_back(static_cast<std::uint8_t>(std::lround(255.0 * w)));
    large.push_back(static_cast<std::uint16_t>(std::lround(65535.0 * w)));
  }
  attributes()["WEIGHTS_0"] = add(small, "VEC4", 5121, 4);
  json["accessors"].back()["normalized"] = true;
  compare(small, 255.0);
  attributes()["WEIGHTS_0"] = add(large, "VEC4", 5123, 4);
  json["accessors"].back()["normalized"] = true;
  compare(large, 65535.0);
}

TEST_F(GltfFigure, EightInfluences) {
  auto one = values<float>(attributes()["WEIGHTS_0"]);
  auto joints = values<std::uint8_t>(attributes()["JOINTS_0"]);
  std::vector<float> two(one.size(), 0.0f);
  std::vector<std::uint16_t> joints_two(joints.size(), 0);
  for (size_t i = 0; i < one.size(); i += 4) {
    for (size_t k = 0; k < 2; ++k) {  // the first of four to the end of eight
      std::swap(one[i + k], two[i + 3 - k]);
      joints_two[i + 3 - k] = joints[i + k];
    }
  }
  attributes()["WEIGHTS_0"] = add(one, "VEC4", 5126, 4);
  attributes()["WEIGHTS_1"] = add(two, "VEC4", 5126, 4);
  attributes()["JOINTS_1"] = add(joints_two, "VEC4", 5123, 4);
  EXPECT_LT(distance_from_plain(read()), 1e-12);
}

// Like a body and its shirt: two meshes on two nodes, each with vertices of its own.
TEST_F(GltfFigure, TwoMeshesUnderOneSkin) {
  json["meshes"].push_back(json["meshes"][0]);
  json["nodes"].push_back({{"name", "Shirt"}, {"mesh", 1}, {"skin", 0}});
  const size_t shirt = json["nodes"].size() - 1;
  json["nodes"].push_back({{"name", "Armature"},
                           {"scale", {0.01, 0.01, 0.01}},
                           {"rotation", {-0.7071067811865476, 0, 0, 0.7071067811865476}},
                           {"children", {shirt}}});
  json["scenes"][0]["nodes"].push_back(shirt + 1);
  const Character both = read();
  std::vector<int> of;
  const int count = static_cast<int>(plain.mesh.vertices.size());
  for (int i = 0; i < 2 * count; ++i) of.push_back(i % count);
  EXPECT_LT(distance_from_plain(both, of), 1e-12);
  ASSERT_EQ(both.parts.size(), 2u);
  EXPECT_EQ(both.parts[1].node, "Shirt");
  EXPECT_EQ(both.parts[1].first_vertex, count);
  EXPECT_EQ(both.mesh.triangles.size(), 2 * plain.mesh.triangles.size());
}

// The mesh of the second skin is in centimetres, which its matrices compensate. Its first joint is
// an arm whose rest pose differs from its bind pose. The skin is placed where the first skin binds
// that arm.
TEST_F(GltfFigure, TwoSkinsUnderOneSkeleton) {
  auto places = values<float>(attributes()["POSITION"]);
  for (float& p : places) p *= 100.0f;
  auto binds = values<float>(json["skins"][0]["inverseBindMatrices"]);
  std::vector<int> arm = {3, 4, 5};  // LeftArm, LeftForeArm, LeftHand
  std::vector<float> of_arm;
  for (const int joint : arm) {
    for (int k = 0; k < 16; ++k) of_arm.push_back(binds[16 * joint + k] * (k < 12 ? 0.01f : 1.0f));
  }
  auto joints = values<std::uint8_t>(attributes()["JOINTS_0"]);
  auto weights = values<float>(attributes()["WEIGHTS_0"]);
  std::vector<int> of;
  const int count = static_cast<int>(plain.mesh.vertices.size());
  for (int i = 0; i < count; ++i) of.push_back(i);
  std::vector<std::uint16_t> faces;  // those whose vertices hang on the arm alone
  std::vector<char> on_arm(count, 1);
  for (int i = 0; i < 4 * count; ++i) {
    const bool is_of_arm = joints[i] >= 3 && joints[i] <= 5;
    if (weights[i] > 0.0f && !is_of_arm) on_arm[i / 4] = 0;
    joints[i] = static_cast<std::uint8_t>(is_of_arm ? joints[i] - 3 : 0);
  }
  std::vector<float> hair_places, hair_weights;
  std::vector<std::uint8_t> hair_joints;
  for (int i = 0; i < count; ++i) {
    if (!on_arm[i]) continue;
    of.push_back(i);
    hair_places.insert(hair_places.end(), &places[3 * i], &places[3 * i] + 3);
    hair_joints.insert(hair_joints.end(), &joints[4 * i], &joints[4 * i] + 4);
    hair_weights.insert(hair_weights.end(), &weights[4 * i], &weights[4 * i] + 4);
  }
  ASSERT_GT(of.size(), count + 100u);
  json["skins"].push_back(
      {{"joints", arm}, {"inverseBindMatrices", add(of_arm, "MAT4", 5126, 16)}});
  const Json sleeve = {{"POSITION", add(hair_places, "VEC3", 5126, 3)},
                       {"JOINTS_0", add(hair_joints, "VEC4", 5121, 4)},
                       {"WEIGHTS_0", add(hair_weights, "VEC4", 5126, 4)}};
  json["meshes"].push_back({{"primitives", {{{"attributes", sleeve}}}}});
  json["nodes"].push_back({{"name", "Sleeve"}, {"mesh", 1}, {"skin", 1}});
  json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
  EXPECT_LT(distance_from_plain(read(), of), 1e-6);
  // The bind pose is what the matrices say, whatever the arm does at rest.
  json["nodes"][3]["rotation"] = {0, 0, 0.3826834323650898, 0.9238795325112867};
  const Character turned = read();
  ASSERT_EQ(turned.mesh.vertices.size(), of.size());
  for (size_t i = 0; i < of.size(); ++i) {
    ASSERT_LT((turned.mesh.vertices[i] - plain.mesh.vertices[of[i]]).norm(), 1e-6) << i;
  }
}

TEST_F(GltfFigure, StripsAndFans) {
  json["meshes"][0]["primitives"].push_back(
      {{"attributes", attributes()},
       {"mode", 5},
       {"indices", add(std::vector<std::uint32_t>{7, 8, 9, 10}, "SCALAR", 5125, 1)}});
  json["meshes"][0]["primitives"].push_back(
      {{"attributes", attributes()},
       {"mode", 6},
       {"indices", add(std::vector<std::uint8_t>{7, 8, 9, 10}, "SCALAR", 5121, 1)}});
  const Character character = read();
  const int count = static_cast<int>(plain.mesh.vertices.size());
  const size_t first = plain.mesh.triangles.size();
  ASSERT_EQ(character.mesh.triangles.size(), first + 4);
  const int a = count + 7, b = 2 * count + 7;
  EXPECT_EQ(character.mesh.triangles[first], (Triangle{a, a + 1, a + 2}));
  EXPECT_EQ(character.mesh.triangles[first + 1], (Triangle{a + 1, a + 3, a + 2}));
  EXPECT_EQ(character.mesh.triangles[first + 2], (Triangle{b, b + 1, b + 2}));
  EXPECT_EQ(character.mesh.triangles[first + 3], (Triangle{b, b + 2, b + 3}));
}

TEST_F(GltfFigure, BonesThatVrmNames) {
  const Json before = json;
  const auto arm_of = [](const Character& character) {
    std::string all;
    for (const auto& [bone, body] : character.humanoid) {
      all += bone + "=" + character.skeleton.body_names[body] + " ";
    }
    return all;
  };
  json["extensions"]["VRMC_vrm"]["humanoid"]["humanBones"] = {{"rightUpperArm", {{"node", 7}}},
                                                              {"rightHand", {{"node", 9}}}};
  EXPECT_EQ(arm_of(read("x.vrm")), "rightHand=RightHand rightUpperArm=RightArm ");
  json = before;
  json["extensions"]["VRM"]["humanoid"]["humanBones"] = {{{"bone", "rightUpperArm"}, {"node", 7}},
                                                         {{"bone", "rightHand"}, {"node", 9}}};
  EXPECT_EQ(arm_of(read("x.vrm")), "rightUpperArm=RightArm rightHand=RightHand ");
  json["extensions"]["VRM"]["humanoid"]["humanBones"][0]["node"] = 700;
  EXPECT_HAS(refusal("x.vrm"), "humanBones names nodes[700] of 11");
}

TEST_F(GltfFigure, CompressionIsNamed) {
  const Json before = json;
  json["accessors"][0].erase("bufferView");
  primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}};
  EXPECT_HAS(refusal(), "KHR_draco_mesh_compression");
  EXPECT_HAS(refusal(), "without compression");
  json = before;
  json["buffers"].push_back({{"byteLength", 1000}});
  for (Json& view : json["bufferViews"]) {
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0}};
    view["buffer"] = 1;
  }
  std::string text = json.dump();
  json["buffers"].erase(1);
  const std::string what = input_error([&] { import_character(write("x.gltf", text)); });
  EXPECT_HAS(what, "EXT_meshopt_compression");
  EXPECT_HAS(what, "without compression");
}

// Each error names its location, and no memory is allocated for data that do not exist.
TEST_F(GltfFigure, WhatDoesNotHoldIsRefused) {
  const Json before = json;
  const auto tell = [&](const char* part) {
    EXPECT_HAS(refusal(), part);
    json = before;
  };
  json["accessors"][0]["count"] = 9007199254740991;
  tell("accessors[0] reaches beyond its view");
  json["accessors"][0]["count"] = -1;
  tell("accessors[0].count is no whole number of at least 0");
  json["accessors"][0]["byteOffset"] = 1e300;
  tell("byteOffset is no whole number");
  json["accessors"][0]["componentType"] = 5124;
  tell("accessors[0].componentType is none of the format's");
  json["accessors"][0]["type"] = "VEC2";
  tell("accessors[0] is not of the width");
  json["bufferViews"][0]["byteLength"] = 4294967295;
  tell("bufferViews[0] reaches beyond the");
  json["bufferViews"][0]["buffer"] = 3;
  tell("bufferViews[0] names buffers[3] of 1");
  json["accessors"][0].erase("bufferView");
  json["accessors"][0]["extensions"]["EXT_somewhere_else"] = {};
  tell("accessors[0] has no data");
  json["accessors"][0].erase("bufferView");
  json["accessors"][0]["count"] = 1000000000000;
  json["accessors"][0]["sparse"] = {{"count", 1}};
  tell("accessors[0] has too many items");
  primitive()["attributes"]["POSITION"] = add(std::vector<float>{0, 0, 0}, "VEC3", 5126, 3);
  tell("names vertex");
  primitive()["attributes"]["WEIGHTS_0"] = add(std::vector<float>{1, 0, 0, 0}, "VEC4", 5126, 4);
  tell("fewer weights than vertices");
  json["skins"][0]["joints"] = {0, 1};
  tell("of joint 2 of 2 on vertex");
  json["skins"][0]["joints"].push_back(99);
  tell("names nodes[99]");
  json["nodes"][5]["children"] = {1};
  tell("hangs on two nodes");
  json["nodes"][5]["scale"] = {1, 0, 1};
  tell("node \"LeftHand\" has no sound transform");
  json["scenes"][0]["nodes"] = {0, 3};
  tell("stands in the scene twice");
  json["asset"]["version"] = "1.0";
  tell("is glTF 1.0");
  json["meshes"] = 7;
  tell("meshes is no list");
  json["meshes"] = Json::array();
  tell("names meshes[0] of 0");
  json["nodes"][10].erase("mesh");
  tell("has no mesh");
  json["animations"][0]["channels"][0]["sampler"] = 77;
  tell("animations[0] names samplers[77]");
  bytes.resize(1000);
  tell("reaches beyond the 1000 bytes");
  EXPECT_HAS(input_error([&] { import_character(write("x.glb", as_glb().substr(0, 2000))); }),
             "is cut short");
  EXPECT_HAS(input_error([&] { import_character(write("x.glb", "")); }), "x.glb");
}

}  // namespace
}  // namespace thew::tests
