// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "tests/unit/tools/export/glb_reader.h"

namespace thew::tests {

namespace fs = std::filesystem;

inline constexpr const char* kDressed = THEW_SOURCE_DIR "/tests/scenes/figure/dressed.gltf";
inline constexpr double kScale = 0.5;                 // [rig] scale
inline constexpr std::size_t kBody = 11, kArms = 12;  // nodes of the file
inline constexpr int kFrames = 6;

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

  Glb put_onto(const ExportChoice& choice, int basis = 0) {
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

}  // namespace thew::tests
