// SPDX-License-Identifier: Apache-2.0
//
// A character that went through a bake comes back as itself, deformed. The bake is made up: the
// figure in its pieces, moved by an animation, with a swelling on one arm.
#include <gtest/gtest.h>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "tests/unit/tools/export/glb_reader.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDressed = THEW_SOURCE_DIR "/tests/scenes/figure/dressed.gltf";
constexpr double kScale = 0.5;                 // [rig] scale
constexpr std::size_t kBody = 11, kArms = 12;  // nodes of the file
constexpr int kFrames = 6;

class OntoTest : public ExportTest {
 protected:
  OntoTest() {
    json input = json::parse(bytes_of(kDressed));
    // The place of a node whose mesh has a skin is to be ignored.
    input["nodes"][kArms]["translation"] = {30.0, -20.0, 10.0};
    input["nodes"][kArms]["rotation"] = {0.6, 0.0, 0.0, 0.8};
    put_bytes(character_, input.dump());
    const std::string uri = input["buffers"][0]["uri"];
    was_.doc = input;
    was_.numbers = decoded(uri.substr(uri.find(',') + 1));
    plain_ = import_character(character_, kScale);
  }

  static std::string decoded(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    unsigned value = 0;
    int bits = 0;
    for (const char c : text.substr(0, text.find('='))) {
      value = value << 6 | static_cast<unsigned>(digits.find(c));
      bits += 6;
      if (bits < 8) continue;
      bits -= 8;
      out.push_back(static_cast<char>(value >> bits & 255));
    }
    return out;
  }

  static std::vector<BodyFrame> rows(const std::vector<Affine>& world) {
    std::vector<BodyFrame> out(world.size());
    for (std::size_t b = 0; b < world.size(); ++b) {
      for (int k = 0; k < 12; ++k) out[b][k] = world[b].matrix()(k / 4, k % 4);
    }
    return out;
  }

  /// Frames 1 to 6 of the animation. What lies within 0.2 m of a point on the left forearm at rest,
  /// of the whole or of the trunk, swells by up to 6 mm.
  void bake_character(const Vec3& middle) {
    const BodyClip& clip = plain_.animations.at(0);
    BakeInfo info;
    info.scene_name = "bent";
    info.fps = 24.0;
    info.double_precision = true;
    for (int f = 1; f <= kFrames; ++f) info.frames.push_back(f);
    std::vector<Affine> world;
    animated_bodies(plain_, clip, 1.0, world);  // any pose but the file's own
    info.character = {"dressed.gltf", kScale, rows(world)};
    Points x;
    skin_vertices(plain_.skin, plain_.mesh, world, x);
    TriMesh rest{{}, plain_.mesh.triangles};
    for (const Point& p : x) rest.vertices.push_back(to_vec(p));
    info.meshes = {{"skin", BakeMesh::Kind::kSkin, rest, {}, {}}};
    BakeWriter writer(folder_ / "out", info, false);
    for (const int number : info.frames) {
      BakeFrame frame;
      frame.frame = number;
      animated_bodies(plain_, clip, (number - 1) / 5.0, world);
      frame.bodies = rows(world);
      skin_vertices(plain_.skin, plain_.mesh, world, x);
      auto& positions = frame.positions.emplace_back();
      for (const Point& p : x) positions.push_back(to_vec(p));
      const std::vector<Vec3> out = vertex_normals({positions, joined_triangles(plain_.mesh)});
      for (std::size_t v = 0; v < x.size(); ++v) {
        const auto first = static_cast<std::size_t>(plain_.map_back[v]);
        const double near =
            1.0 - (plain_.mesh.vertices[first] - kScale * middle).norm() / (kScale * 0.2);
        if (near > 0.0) positions[v] += 0.003 * near * (1.0 + std::sin(0.9 * number)) * out[first];
      }
      writer.write(frame);
    }
    writer.pack();
    options_.input = folder_ / "out/bake.h5";
    reader_.emplace(options_.input);
  }

  Glb put_onto(const OntoChoice& choice, int basis = 0) {
    options_.out = folder_ / "onto.glb";
    testing::internal::CaptureStdout();
    try {
      EXPECT_EQ(export_command(options_, {}, basis, choice), ExitCode::kDone);
    } catch (const Error& error) {
      ADD_FAILURE() << error.what();
    }
    said_ = testing::internal::GetCapturedStdout();
    return read_glb(options_.out);
  }

  /// The skin as a viewer has it at a key, in the order of the bake, in m.
  Shape played(const Glb& glb, std::size_t key) const {
    const GlbPlayer player(glb, key);
    Shape all;
    for (const MeshPart& part : plain_.parts) {
      const Shape shape = player.shape(static_cast<std::size_t>(part.node_index),
                                       static_cast<std::size_t>(part.primitive));
      for (const Vec3& p : shape.positions) all.positions.push_back(kScale * p);
      all.normals.insert(all.normals.end(), shape.normals.begin(), shape.normals.end());
    }
    return all;
  }

  /// mm: the largest distance from the bake, and RMS.
  std::pair<double, double> deviation(const Glb& glb) const {
    double largest = 0.0, squares = 0.0, count = 0.0;
    for (int i = 0; i < kFrames; ++i) {
      const std::vector<Vec3> read = played(glb, static_cast<std::size_t>(i)).positions,
                              baked = positions("skin", i);
      EXPECT_EQ(read.size(), baked.size());
      for (std::size_t v = 0; v < baked.size(); ++v) {
        const double apart = 1e3 * (read[v] - baked[v]).norm();
        largest = std::max(largest, apart);
        squares += apart * apart;
        count += 1.0;
      }
    }
    return {largest, std::sqrt(squares / count)};
  }

  /// Degrees between normals of vertices that the file has at one place with one normal.
  double largest_split(const Glb& glb) const {
    std::vector<Vec3> before;
    for (const MeshPart& part : plain_.parts) {
      const std::vector<float> flat = was_.floats(was_.doc["meshes"][part.mesh_index]["primitives"]
                                                          [part.primitive]["attributes"]["NORMAL"]);
      for (std::size_t k = 0; k < flat.size(); k += 3) {
        before.emplace_back(flat[k], flat[k + 1], flat[k + 2]);
      }
    }
    double largest = 0.0;
    int pairs = 0;
    for (int i = 0; i < kFrames; ++i) {
      const std::vector<Vec3> after = played(glb, static_cast<std::size_t>(i)).normals;
      for (std::size_t v = 0; v < after.size(); ++v) {
        const auto first = static_cast<std::size_t>(plain_.map_back[v]);
        if (first == v || (before[v] - before[first]).norm() > 1e-4) continue;
        ++pairs;
        largest = std::max(
            largest, arc_tan2(after[v].cross(after[first]).norm(), after[v].dot(after[first])));
      }
    }
    EXPECT_GT(pairs, 50 * kFrames);
    return largest / kDegree;
  }

  // All that is none of the skin's shape.
  void expect_same_asset(const Glb& glb) const {
    for (const char* list : {"scenes", "materials", "textures"}) {
      EXPECT_EQ(glb.doc[list], was_.doc[list]) << list;
    }
    EXPECT_EQ(glb.doc["asset"]["generator"], was_.doc["asset"]["generator"]);
    EXPECT_EQ(glb.doc["asset"]["extras"]["author"], "nobody");
    ASSERT_EQ(glb.doc["nodes"].size(), was_.doc["nodes"].size());
    for (std::size_t n = 0; n < glb.doc["nodes"].size(); ++n) {
      json now = glb.doc["nodes"][n], before = was_.doc["nodes"][n];
      now.erase("skin");
      before.erase("skin");
      EXPECT_EQ(now, before);
    }
    ASSERT_EQ(glb.doc["meshes"].size(), was_.doc["meshes"].size());
    for (std::size_t m = 0; m < glb.doc["meshes"].size(); ++m) {
      const json &now = glb.doc["meshes"][m], &before = was_.doc["meshes"][m];
      EXPECT_EQ(now["name"], before["name"]);
      ASSERT_EQ(now["primitives"].size(), before["primitives"].size());
      for (std::size_t p = 0; p < now["primitives"].size(); ++p) {
        expect_same_primitive(glb, now["primitives"][p], before["primitives"][p]);
      }
    }
    const json& image = glb.doc["images"][0];
    EXPECT_EQ(image["name"], "check");
    const std::string png = was_.doc["images"][0]["uri"];
    ByteReader in = glb.at_view(image["bufferView"]);
    const std::string bytes = decoded(png.substr(png.find(',') + 1));
    EXPECT_EQ(in.bytes.substr(in.at, bytes.size()), bytes);
  }

  void expect_same_primitive(const Glb& glb, const json& now, const json& before) const {
    EXPECT_EQ(now["material"], before["material"]);
    const json &a = now["attributes"], &b = before["attributes"];
    EXPECT_EQ(glb.accessor(a["POSITION"])["count"], was_.accessor(b["POSITION"])["count"]);
    EXPECT_EQ(a.contains("TEXCOORD_0"), b.contains("TEXCOORD_0"));
    if (b.contains("TEXCOORD_0")) {
      EXPECT_EQ(glb.floats(a["TEXCOORD_0"]), was_.floats(b["TEXCOORD_0"]));
    }
    EXPECT_EQ(now.contains("indices"), before.contains("indices"));
    if (before.contains("indices")) {
      EXPECT_EQ(glb.items<std::uint16_t>(now["indices"]),
                was_.items<std::uint16_t>(before["indices"]));
    }
  }

  const Vec3 arm_{0.45, 1.14, 0.0}, chest_{0.1, 1.2, 0.1};  // m, unscaled
  const fs::path character_ = folder_ / "dressed.gltf";
  Glb was_;
  Character plain_;
};

TEST_F(OntoTest, ComesBackAsItselfByMorphTargets) {
  bake_character(arm_);
  const Glb glb = put_onto({});  // found where the scene's folder would be
  EXPECT_NE(said_.find("onto " + fs::absolute(character_).string()), std::string::npos) << said_;
  expect_same_asset(glb);
  const json& arms = glb.doc["meshes"][1]["primitives"];
  for (const json& primitive : arms) {
    EXPECT_EQ(primitive["targets"].size(), static_cast<std::size_t>(kFrames));
    for (const char* of_bind : {"JOINTS_0", "WEIGHTS_0", "TANGENT"}) {
      EXPECT_FALSE(primitive["attributes"].contains(of_bind));
    }
  }
  EXPECT_FALSE(glb.doc["nodes"][kArms].contains("skin"));
  // What muscles do not reach stays as it is.
  EXPECT_EQ(glb.doc["nodes"][kBody]["skin"], 0);
  EXPECT_EQ(glb.doc["meshes"][0]["primitives"][0]["targets"].size(), 1u);
  EXPECT_FALSE(glb.doc["meshes"][2]["primitives"][0].contains("targets"));
  EXPECT_EQ(glb.doc["animations"].size(), 1u);
  EXPECT_LE(deviation(glb).first, 3e-4);  // mm
  EXPECT_LE(largest_split(glb), 1e-3);
  const json& animation = glb.doc["animations"][0];
  const std::vector<float> seconds = glb.floats(animation["samplers"][0]["input"]);
  for (int i = 0; i < kFrames; ++i) EXPECT_EQ(seconds[i], static_cast<float>((i + 1) / 24.0));
}

TEST_F(OntoTest, CorrectivesAddToWhatTheWeightsDo) {
  bake_character(arm_);
  const Glb glb = put_onto({"", true});
  expect_same_asset(glb);
  EXPECT_EQ(glb.doc["skins"].size(), 1u);
  for (std::size_t m = 0; m < 2; ++m) {
    const json &now = glb.doc["meshes"][m]["primitives"][0]["attributes"],
               &before = was_.doc["meshes"][m]["primitives"][0]["attributes"];
    for (const char* kept : {"POSITION", "NORMAL", "WEIGHTS_0"}) {
      EXPECT_EQ(glb.floats(now[kept]), was_.floats(before[kept]));
    }
    EXPECT_EQ(glb.items<std::uint8_t>(now["JOINTS_0"]),
              was_.items<std::uint8_t>(before["JOINTS_0"]));
  }
  // The file's own animations stay, behind the baked one.
  ASSERT_EQ(glb.doc["animations"].size(), 3u);
  EXPECT_EQ(glb.doc["animations"][0]["name"], "bent");
  EXPECT_EQ(glb.doc["animations"][2]["channels"].size(), 1u);
  const auto [largest, rms] = deviation(glb);
  EXPECT_LE(largest, 1e-3);  // mm
  EXPECT_NEAR(largest, glb.doc["asset"]["extras"]["position_error_max_mm"].get<double>(), 2e-4);
  // Without its animation the file is the character as it was.
  for (const float weight : glb.doc["meshes"][1]["weights"]) EXPECT_EQ(weight, 0.0f);
  EXPECT_LE(largest_split(glb), 1e-3);
}

TEST_F(OntoTest, ABasisOfCorrectivesStatesTheErrorInThePose) {
  bake_character(arm_);
  for (const bool correctives : {true, false}) {
    for (const int basis : {1, 2}) {
      const Glb glb = put_onto({character_, correctives}, basis);
      EXPECT_LE(glb.doc["meshes"][1]["primitives"][0]["targets"].size(),
                static_cast<std::size_t>(basis + 1));
      const auto [largest, rms] = deviation(glb);
      const json& stated = glb.doc["asset"]["extras"];
      EXPECT_NEAR(largest, stated["position_error_max_mm"].get<double>(), 1e-3);
      EXPECT_NEAR(rms, stated["position_error_rms_mm"].get<double>(), 1e-3);
      EXPECT_GT(largest, !correctives && basis == 1 ? 1.0 : 0.0);
      EXPECT_NE(said_.find("position error"), std::string::npos) << said_;
    }
  }
}

// Shape keys of the file's own go before ours, at the weights that the file gives them.
TEST_F(OntoTest, KeepsShapeKeysOfTheFile) {
  bake_character(chest_);
  const Glb glb = put_onto({"", true});
  const json& trunk = glb.doc["meshes"][0];
  ASSERT_EQ(trunk["primitives"][0]["targets"].size(), 1u + kFrames);
  EXPECT_EQ(trunk["extras"]["targetNames"][0], "breath");
  EXPECT_EQ(trunk["weights"].size(), 1u + kFrames);
  EXPECT_LE(deviation(glb).first, 1e-3);
  // Its animation sets one weight, and there are seven now.
  EXPECT_EQ(glb.doc["animations"].size(), 2u);
}

// The figure has the normals of its surface, and so has what comes back. A blend of weights turns
// normals roughly where joints bend, and so correctives are looked at where they do not.
TEST_F(OntoTest, NormalsGoWithTheSurface) {
  bake_character(arm_);
  for (const bool correctives : {false, true}) {
    const Glb glb = put_onto({"", correctives});
    double largest = 0.0;
    for (int i = 0; i < (correctives ? 1 : kFrames); ++i) {
      const Shape read = played(glb, static_cast<std::size_t>(i));
      const std::vector<Vec3> baked = positions("skin", i);
      const std::vector<Vec3> normals = vertex_normals({baked, joined_triangles(plain_.mesh)});
      for (int v = plain_.parts[1].first_vertex; v < plain_.parts[3].first_vertex; ++v) {
        const Vec3& normal = normals[static_cast<std::size_t>(plain_.map_back[v])];
        largest = std::max(
            largest, arc_tan2(read.normals[v].cross(normal).norm(), read.normals[v].dot(normal)));
      }
    }
    std::printf("%s: normals %.2g degrees from the surface's\n",
                correctives ? "correctives" : "morph targets", largest / kDegree);
    EXPECT_LE(largest / kDegree, 0.01);
  }
}

TEST_F(OntoTest, AnotherCharacterIsRefused) {
  bake_character(arm_);
  options_.out = folder_ / "onto.glb";
  const auto refused = [&](ErrorCode code, const std::string& word, const OntoChoice& choice,
                           const std::vector<std::string>& meshes = {}) {
    expect_error(code, word, [&] { export_command(options_, meshes, 0, choice); });
    EXPECT_FALSE(fs::exists(options_.out));
  };
  refused(ErrorCode::kInput, "is not the character of the bake: its meshes have",
          {THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf", false});
  json moved = was_.doc;
  moved["skins"][0]["joints"][4] = 5;
  put_bytes(folder_ / "moved.gltf", moved.dump());
  refused(ErrorCode::kInput, "mm from the bake's at rest", {folder_ / "moved.gltf", false});
  for (const auto& [place, word] :
       {std::pair("/meshes/0/primitives/0/attributes/_EXTRA", "that it does not have"),
        std::pair("/meshes/1/primitives/0/indices", "accessors[9999]"),
        std::pair("/bufferViews/0/byteLength", "reaches beyond"),
        std::pair("/nodes/12/mesh", "meshes[9999]")}) {
    json broken = was_.doc;
    broken[json::json_pointer(place)] = 9999999;
    if (std::string(word).find("9999") != std::string::npos) {
      broken[json::json_pointer(place)] = 9999;
    }
    put_bytes(folder_ / "broken.gltf", broken.dump());
    refused(ErrorCode::kInput, word, {folder_ / "broken.gltf", false});
  }
  refused(ErrorCode::kInput, "none.gltf", {folder_ / "none.gltf", false});
  refused(ErrorCode::kUsage, "is no .gltf, .glb or .vrm", {folder_ / "a.fbx", false});
  refused(ErrorCode::kUsage, "leave one of them out", {character_, false}, {"skin"});
  refused(ErrorCode::kUsage, "--correctives needs", {"none", true});
  options_.out = folder_ / "onto.pc2";
  refused(ErrorCode::kUsage, "is not for", {character_, false});
  put_bytes(folder_ / "out/plain.glb", "");
  options_.out = folder_ / "plain.glb";
  fs::remove(character_);
  refused(ErrorCode::kUsage, "--correctives needs", {"", true});
  const Glb glb = read_glb(write("plain.glb", {}));
  EXPECT_EQ(glb.doc["nodes"].size(), 1u);
  EXPECT_NE(said_.find("--onto FILE"), std::string::npos) << said_;
}

// Formats that hold the bake's meshes take texture coordinates and materials from the character.
TEST_F(OntoTest, UsdHasItsTextureCoordinates) {
  bake_character({-0.2, 1.45, 0.0});
  const std::string usd = bytes_of(write("bent.usda", {}));
  std::vector<float> expected;
  for (const MeshPart& part : plain_.parts) {
    const json& attributes =
        was_.doc["meshes"][part.mesh_index]["primitives"][part.primitive]["attributes"];
    if (!attributes.contains("TEXCOORD_0")) {
      const auto count = was_.doc["accessors"][attributes["POSITION"].get<int>()]["count"];
      expected.insert(expected.end(), 2 * count.get<std::size_t>(), 0.0f);
      continue;
    }
    const std::vector<float> uv = was_.floats(attributes["TEXCOORD_0"]);
    for (std::size_t i = 0; i < uv.size(); i += 2) {
      expected.insert(expected.end(), {uv[i], static_cast<float>(1.0 - uv[i + 1])});
    }
    EXPECT_NE(usd.find("def GeomSubset \"" + part.material + "\""), std::string::npos)
        << part.material;
  }
  const auto numbers = [](std::string text) {
    for (char& c : text) c = std::string("()[],/").find(c) == std::string::npos ? c : ' ';
    std::istringstream in(text);
    std::vector<float> values;
    for (float value; in >> value;) values.push_back(value);
    return values;
  };
  const std::string named = "texCoord2f[] primvars:st = ";
  const std::size_t at = usd.find(named) + named.size();
  EXPECT_EQ(numbers(usd.substr(at, usd.find(']', at) - at)), expected);
  // Where the file has one normal at one place, there is one normal.
  std::vector<Vec3> split;
  for (const MeshPart& part : plain_.parts) {
    const auto& attributes =
        was_.doc["meshes"][part.mesh_index]["primitives"][part.primitive]["attributes"];
    const std::vector<float> of = was_.floats(attributes["NORMAL"]);
    for (std::size_t i = 0; i < of.size(); i += 3) split.emplace_back(of[i], of[i + 1], of[i + 2]);
  }
  const std::size_t sample = usd.find(" 3: [", usd.find(" normals.timeSamples")) + 5;
  const std::vector<float> normals = numbers(usd.substr(sample, usd.find(']', sample) - sample));
  ASSERT_EQ(normals.size(), 3 * split.size());
  int pairs = 0;
  for (std::size_t v = 0; v < split.size(); ++v) {
    const auto first = static_cast<std::size_t>(plain_.map_back[v]);
    if (first == v || split[first].dot(split[v]) < 0.9999) continue;
    ++pairs;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(normals[3 * v + k], normals[3 * first + k]) << v;
  }
  EXPECT_GT(pairs, 0);
  put_bytes(character_, bytes_of(THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf"));
  EXPECT_EQ(bytes_of(write("bent.usda", {})).find("primvars:st"), std::string::npos);
  EXPECT_NE(said_.find("without texture coordinates"), std::string::npos) << said_;
}

TEST_F(OntoTest, ABakeWithoutACharacterGoesOntoNone) {
  bake(true);
  options_.out = folder_ / "onto.glb";
  expect_error(ErrorCode::kInput, "is not the character", [&] {
    export_command(options_, {}, 0, {character_, false});
  });
}

}  // namespace
}  // namespace thew::tests
