// SPDX-License-Identifier: Apache-2.0
//
// glTF, read back by a reader of the test's own and by assimp.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <assimp/Importer.hpp>
#include <nlohmann/json.hpp>

#include "tests/unit/tools/export/export.h"
#include "tools/export/basis.h"

namespace thew::tests {
namespace {

using nlohmann::json;

struct Glb {
  json doc;
  std::string numbers;

  std::vector<float> floats(const json& accessor_number) const {
    const json& accessor = doc["accessors"][accessor_number.get<std::size_t>()];
    const json& view = doc["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t width = accessor["type"] == "VEC3" ? 3 : 1;
    EXPECT_EQ(view["byteLength"].get<std::size_t>(),
              accessor["count"].get<std::size_t>() * width * 4);
    ByteReader in{numbers, view["byteOffset"].get<std::size_t>()};
    std::vector<float> values;
    for (std::size_t i = 0; i < accessor["count"].get<std::size_t>() * width; ++i) {
      values.push_back(in.take<float>());
    }
    return values;
  }
};

Glb read_glb(const std::filesystem::path& file) {
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

/// A mesh at a key of the animation, in double from what the file holds.
std::vector<double> shape(const Glb& glb, std::size_t m, std::size_t key) {
  const json& primitive = glb.doc["meshes"][m]["primitives"][0];
  const std::vector<float> base = glb.floats(primitive["attributes"]["POSITION"]);
  std::vector<double> sum(base.begin(), base.end());
  if (!primitive.contains("targets")) return sum;
  std::vector<float> weights;
  for (const json& channel : glb.doc["animations"][0]["channels"]) {
    const std::size_t node = channel["target"]["node"];
    if (glb.doc["nodes"][node]["mesh"] != m) continue;
    const std::size_t sampler = channel["sampler"];
    weights = glb.floats(glb.doc["animations"][0]["samplers"][sampler]["output"]);
  }
  const std::size_t count = primitive["targets"].size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::vector<float> target = glb.floats(primitive["targets"][k]["POSITION"]);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      sum[i] += double{weights.at(key * count + k)} * target[i];
    }
  }
  return sum;
}

double largest_error(const Glb& glb, std::size_t m, std::size_t key,
                     const std::vector<Vec3>& baked) {
  const std::vector<double> read = shape(glb, m, key);
  EXPECT_EQ(read.size(), 3 * baked.size());
  double error = 0.0;
  for (std::size_t v = 0; v < baked.size(); ++v) {
    error =
        std::max(error, (Vec3(read[3 * v], read[3 * v + 1], read[3 * v + 2]) - baked[v]).norm());
  }
  return error;
}

TEST_F(ExportTest, GlbHasATargetAFrame) {
  bake(true);
  const Glb glb = read_glb(write("all.glb", {}));
  EXPECT_EQ(glb.doc["asset"]["extras"]["units"], "m");
  EXPECT_EQ(glb.doc["asset"]["extras"]["first_frame"], "-2");
  const char* names[] = {"biceps", "skin", "ulna"};
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(glb.doc["meshes"][m]["name"], names[m]);
    EXPECT_EQ(glb.doc["meshes"][m]["primitives"][0]["targets"].size(), 4u);
    for (int i = 0; i < 4; ++i) {
      EXPECT_LE(largest_error(glb, m, i, positions(names[m], i)), 2e-7);  // 2 m, as float32
    }
  }
  const json& sampler = glb.doc["animations"][0]["samplers"][0];
  const std::vector<float> seconds = glb.floats(sampler["input"]);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(seconds[i], static_cast<float>(2 * i / 24.0));
}

TEST_F(ExportTest, GlbNormalsAreThoseOfTheFrame) {
  bake(true);
  const Glb glb = read_glb(write("ulna.glb", {"ulna"}));
  const json& primitive = glb.doc["meshes"][0]["primitives"][0];
  const std::vector<float> base = glb.floats(primitive["attributes"]["NORMAL"]);
  for (int i = 0; i < 4; ++i) {
    const std::vector<float> change = glb.floats(primitive["targets"][i]["NORMAL"]);
    const auto expected =
        as_floats(vertex_normals({positions("ulna", i), mesh("ulna").rest.triangles}));
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_NEAR(base[k] + change[k], expected[k], 1e-6f);
    }
  }
}

// The motion of the small bake is along one direction: one target holds it.
TEST_F(ExportTest, ABasisOfOneHoldsAMotionOfOne) {
  bake(true);
  const Glb glb = read_glb(write("all.glb", {}, 3));
  EXPECT_NE(said_.find("1 morph targets"), std::string::npos) << said_;
  const char* names[] = {"biceps", "skin", "ulna"};
  for (std::size_t m = 0; m < 3; ++m) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_LE(largest_error(glb, m, i, positions(names[m], i)), 4e-7);
    }
  }
}

// The mean of n equal frames differs from them by rounding, which is no motion.
TEST_F(ExportTest, ABasisOfWhatStandsStillHasNoTargets) {
  const std::vector<Vec3> still = {Vec3(0.1, 0.7, -0.3), Vec3(1.1, 0.9, 0.013), Vec3(3, 1e-9, 7)};
  for (int count = 1; count < 30; ++count) {
    const std::vector<const std::vector<Vec3>*> frames(count, &still);
    const MotionBasis basis = fit_motion_basis(frames, 4);
    EXPECT_TRUE(basis.factors.empty()) << count;
    const std::vector<Vec3> base = combine(basis.base_factors, frames);
    for (size_t v = 0; v < still.size(); ++v) EXPECT_LT((base[v] - still[v]).norm(), 1e-14);
  }
}

TEST_F(ExportTest, ABasisStatesTheErrorThatAReaderFinds) {
  options_.input = folder_ / "bake.h5";
  BakeInfo info = small_info(true);
  BakeWriter writer(folder_, info, false);
  for (const int f : info.frames) {
    BakeFrame frame = small_frame(info, f);
    for (auto& mesh : frame.positions) {
      for (std::size_t v = 0; v < mesh.size(); ++v) mesh[v].z() += 0.01 * ((f * 37 + 11 * v) % 7);
    }
    for (Vec3& p : frame.positions[2]) p = Vec3(1, 2, 3);  // the skin is one point and stands still
    writer.write(frame);
  }
  writer.pack();
  reader_.emplace(folder_ / "bake.h5");
  for (const int basis : {1, 2, 3}) {
    const Glb glb = read_glb(write("all.glb", {}, basis));
    double error = 0.0;
    const char* names[] = {"biceps", "skin", "ulna"};
    for (std::size_t m = 0; m < 3; ++m) {
      for (int i = 0; i < 4; ++i) {
        error = std::max(error, largest_error(glb, m, i, positions(names[m], i)));
      }
    }
    char stated[40];
    std::snprintf(stated, sizeof stated, "position error %.3g mm at most", 1e3 * error);
    EXPECT_NE(said_.find(stated), std::string::npos) << stated << "\n" << said_;
    EXPECT_FALSE(glb.doc["meshes"][1]["primitives"][0].contains("targets"));
    EXPECT_GT(error, basis < 3 ? 1e-4 : 0.0);
    EXPECT_LT(error, basis < 3 ? 1.0 : 1e-6);
    for (const json& sampler : glb.doc["animations"][0]["samplers"]) {
      for (const float weight : glb.floats(sampler["output"])) {
        EXPECT_GE(weight, 0.0f);
        EXPECT_LE(weight, 1.0f);
      }
    }
  }
}

TEST_F(ExportTest, AssimpReadsTheSameVerticesInTheSameOrder) {
  bake(true);
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile(write("all.glb", {}).string(), aiProcess_ValidateDataStructure);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumMeshes, 3u);
  double largest = 0.0;
  for (unsigned m = 0; m < 3; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const BakeMesh& baked = reader_->info().meshes[m];
    ASSERT_EQ(mesh.mNumVertices, baked.rest.vertices.size());
    ASSERT_EQ(mesh.mNumAnimMeshes, 4u);
    ASSERT_EQ(mesh.mNumFaces, baked.rest.triangles.size());
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(mesh.mFaces[f].mIndices[c], static_cast<unsigned>(baked.rest.triangles[f][c]));
      }
    }
    for (int i = 0; i < 4; ++i) {
      const auto expected = as_floats(positions(baked.name, i));
      for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
        for (unsigned axis = 0; axis < 3; ++axis) {
          largest = std::max(largest, double{std::abs(mesh.mAnimMeshes[i]->mVertices[v][axis] -
                                                      expected[3 * v + axis])});
        }
      }
    }
  }
  std::printf("assimp, glb: largest error %.3g m\n", largest);
  EXPECT_LE(largest, 2.5e-7);  // one bit of float32 at 2 m
  ASSERT_EQ(scene->mNumAnimations, 1u);
  EXPECT_EQ(scene->mAnimations[0]->mNumMorphMeshChannels, 3u);
}

TEST_F(ExportTest, AssimpReadsTheSequences) {
  bake(false);
  write("ulna.obj", {"ulna"});
  write("ulna.ply", {"ulna"});
  double largest = 0.0;
  const char* numbers[] = {"-002", "0000", "0002", "0004"};
  for (int i = 0; i < 4; ++i) {
    const auto expected = as_floats(positions("ulna", i));
    for (const char* ending : {".obj", ".ply"}) {
      Assimp::Importer importer;
      const auto file = folder_ / (std::string("ulna.") + numbers[i] + ending);
      // OBJ's importer splits by corner; joining gives the vertices back, in the order of faces.
      const aiScene* scene = importer.ReadFile(file.string(), 0);
      ASSERT_NE(scene, nullptr) << importer.GetErrorString();
      const aiMesh& mesh = *scene->mMeshes[0];
      const auto& triangles = reader_->info().meshes[place("ulna")].rest.triangles;
      ASSERT_EQ(mesh.mNumFaces, triangles.size());
      for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        for (int c = 0; c < 3; ++c) {
          const aiVector3D& p = mesh.mVertices[mesh.mFaces[f].mIndices[c]];
          for (unsigned axis = 0; axis < 3; ++axis) {
            const float error =
                p[axis] - expected[3 * static_cast<unsigned>(triangles[f][c]) + axis];
            largest = std::max(largest, double{std::abs(error)});
          }
        }
      }
    }
  }
  // Its text reader of OBJ is not exact to the last digit.
  std::printf("assimp, OBJ and PLY: largest error %.3g m\n", largest);
  EXPECT_LE(largest, 2e-7);
}

}  // namespace
}  // namespace thew::tests
