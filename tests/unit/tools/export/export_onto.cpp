// SPDX-License-Identifier: Apache-2.0
//
// A character that went through a bake comes back as itself, deformed. The bake is made up: the
// figure in its pieces, moved by an animation, with a swelling on one arm.
#include <gtest/gtest.h>

#include "tests/unit/tools/export/onto.h"

namespace thew::tests {
namespace {

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
  const auto refused = [&](ErrorCode code, const std::string& word, const ExportChoice& choice,
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
  options_.out = folder_ / "onto.ply";
  refused(ErrorCode::kUsage, "is not for", {character_, false});
  options_.out = folder_ / "onto.pc2";
  refused(ErrorCode::kUsage, "without --mesh and --correctives", {character_, true});
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
  // Materials are bound by part, and the file's image stands beside.
  for (const char* line : {"rel material:binding = </Bake/Looks/cloth>\n",
                           "color3f inputs:diffuseColor.connect = </Bake/Looks/skin/Texture.",
                           "color3f inputs:diffuseColor = (0.2, 0.3, 0.6)\n",
                           "asset inputs:file = @./bent.check_0.png@\n"}) {
    EXPECT_NE(usd.find(line), std::string::npos) << line;
  }
  const std::string image = was_.doc["images"][0]["uri"];
  EXPECT_EQ(bytes_of(folder_ / "bent.check_0.png"), decoded(image.substr(image.find(',') + 1)));
  json broken = was_.doc;
  broken["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = "red";
  put_bytes(character_, broken.dump());
  const std::string without = bytes_of(write("bent.usda", {}));
  EXPECT_NE(without.find("primvars:st"), std::string::npos);
  EXPECT_EQ(without.find("material:binding"), std::string::npos);
  EXPECT_NE(said_.find("without the materials of"), std::string::npos) << said_;
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
