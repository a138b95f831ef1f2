// SPDX-License-Identifier: Apache-2.0
//
// glTF, read back by a reader of the test's own and by assimp.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include <assimp/Importer.hpp>
#include <map>

#include "rig/math.h"
#include "tests/unit/tools/export/glb_reader.h"
#include "tools/export/gltf/basis.h"
#include "tools/export/gltf/gltf.h"

namespace thew::tests {
namespace {

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

// A bone, one node that moves; a skin that stands still; a muscle, by morph targets.
TEST_F(ExportTest, GlbMovesNodesAndShapesOnlyWhereTheyMove) {
  bake({1, 2, 3, 5}, [&](BakeFrame& frame) {
    const Mat3 turn = rotation_about(Vec3(0.6, 0.0, 0.8), 2.0 * frame.frame);
    for (std::size_t v = 0; v < 4; ++v) {
      frame.positions[0][v] = turn * info_.meshes[0].rest.vertices[v] + Vec3(1, frame.frame, 0);
    }
    frame.positions[2] = info_.meshes[2].rest.vertices;
    for (Vec3& p : frame.positions[2]) p.x() += 3.0;
  });
  const Glb glb = read_glb(write("all.glb", {}));
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(glb.doc["meshes"][m]["primitives"][0].contains("targets"), m == 0);
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_LE(largest_error(glb, 0, i, positions("biceps", i)), 2e-7);
    EXPECT_LE(largest_error(glb, 1, i, positions("skin", i)), 2e-7);
  }
  std::map<std::string, std::vector<float>> keys;
  const json& animation = glb.doc["animations"][0];
  for (const json& channel : animation["channels"]) {
    if (channel["target"]["node"] != 2) continue;
    const std::size_t sampler = channel["sampler"];
    keys[channel["target"]["path"]] = glb.floats(animation["samplers"][sampler]["output"]);
  }
  const std::vector<float>&turns = keys["rotation"], &places = keys["translation"];
  ASSERT_EQ(turns.size(), 16u);
  ASSERT_EQ(places.size(), 12u);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Quaterniond turn(turns[4 * i + 3], turns[4 * i], turns[4 * i + 1],
                                  turns[4 * i + 2]);
    const Vec3 place(places[3 * i], places[3 * i + 1], places[3 * i + 2]);
    for (std::size_t v = 0; v < 4; ++v) {
      const Vec3 read = turn * info_.meshes[0].rest.vertices[v] + place;
      EXPECT_LE((read - positions("ulna", i)[v]).norm(), 4e-7);
    }
  }
}

TEST_F(ExportTest, GlbSharesMaterialsByKind) {
  bake(true);
  const Glb glb = read_glb(write("all.glb", {}));
  ASSERT_EQ(glb.doc["materials"].size(), 3u);
  const char* kinds[] = {"muscle", "skin", "bone"};
  for (std::size_t m = 0; m < 3; ++m) {
    const std::size_t material = glb.doc["meshes"][m]["primitives"][0]["material"];
    EXPECT_EQ(glb.doc["materials"][material]["name"], kinds[m]);
  }
}

// Of frames times targets weights, all but one in each frame are zero.
TEST_F(ExportTest, GlbStoresTheWeightsThatAreNotZero) {
  std::vector<int> frames;
  for (int f = 1; f <= 250; ++f) frames.push_back(f);
  bake(frames, [](BakeFrame&) {});
  const auto file = write("biceps.glb", {"biceps"});
  EXPECT_NE(said_.find("--basis"), std::string::npos) << said_;
  const Glb glb = read_glb(file);
  const json& animation = glb.doc["animations"][0];
  const std::size_t output = animation["samplers"][0]["output"];
  const json& accessor = glb.doc["accessors"][output];
  EXPECT_EQ(accessor["count"], 250 * 250);
  EXPECT_EQ(accessor["sparse"]["count"], 250);
  for (const int i : {0, 1, 249}) {
    EXPECT_LE(largest_error(glb, 0, i, positions("biceps", i)), 2e-5);  // at 100 m
  }
  EXPECT_LT(glb.numbers.size(), 40000u);  // 250,000 by the weights alone
  options_.frames = "1-249";
  write("fewer.glb", {"biceps"});
  EXPECT_EQ(said_.find("--basis"), std::string::npos) << said_;
  expect_error(ErrorCode::kUsage, "--basis", [] { check_targets("long.glb", 2049); });
  check_targets("long.glb", 2048);
}

// Where all that has a time says it of frame 1; PC2 says the frame.
TEST_F(ExportTest, FrameOneIsTheSameInstantInAllFormats) {
  bake({1, 2, 4}, [](BakeFrame&) {});
  const double instant = 1.0 / 24.0;
  const Glb glb = read_glb(write("a.glb", {"biceps"}));
  EXPECT_EQ(glb.floats(glb.doc["animations"][0]["samplers"][0]["input"]),
            (std::vector<float>{static_cast<float>(instant), static_cast<float>(2 * instant),
                                static_cast<float>(4 * instant)}));
  ByteReader mdd{bytes_of(write("a.mdd", {"biceps"})), 8};
  EXPECT_EQ(mdd.take<float>(true), static_cast<float>(instant));
  options_.frames = "1-2";
  ByteReader pc2{bytes_of(write("a.pc2", {"biceps"})), 20};
  EXPECT_EQ(pc2.take<float>(), 1.0f);
  options_.frames = "";
  const std::string usda = bytes_of(write("a.usda", {"biceps"}));
  EXPECT_NE(usda.find("startTimeCode = 1\n"), std::string::npos);
  EXPECT_NE(usda.find("timeCodesPerSecond = 24\n"), std::string::npos);
  const std::string xdmf = bytes_of(write("a.xdmf", {"biceps"}));
  const std::string mark = "<Time Value=\"";
  EXPECT_EQ(std::stod(xdmf.substr(xdmf.find(mark) + mark.size())), instant);
  std::string seconds(sizeof instant, '\0');
  std::memcpy(seconds.data(), &instant, sizeof instant);
  EXPECT_NE(bytes_of(write("a.abc", {"biceps"})).find(seconds), std::string::npos);
}

TEST_F(ExportTest, ABasisHasTheRestPoseAsItsBase) {
  bake({1, 2, 3, 4, 5, 6}, [](BakeFrame& frame) {
    for (std::size_t v = 0; v < 4; ++v) {  // two modes, that turn the faces
      frame.positions[1][v].x() += 0.1 * std::sin(frame.frame) * static_cast<double>(v);
      frame.positions[1][v].y() += 0.1 * std::cos(frame.frame) * static_cast<double>(v * v);
    }
  });
  for (const int basis : {3, 6}) {
    const Glb glb = read_glb(write("biceps.glb", {"biceps"}, basis));
    const json& primitive = glb.doc["meshes"][0]["primitives"][0];
    EXPECT_EQ(glb.floats(primitive["attributes"]["POSITION"]),
              as_floats(mesh("biceps").rest.vertices));
    EXPECT_EQ(glb.floats(primitive["attributes"]["NORMAL"]),
              as_floats(unit_normals(choose_shot(*reader_, {"biceps"}, ""), 0,
                                     mesh("biceps").rest.vertices)));
    for (int i = 0; i < 6; ++i) EXPECT_LE(largest_error(glb, 0, i, positions("biceps", i)), 4e-7);
    const double stated = glb.doc["asset"]["extras"]["normal_error_max_deg"];
    EXPECT_LT(stated, basis == 6 ? 1e-4 : 20.0);  // a target a frame again, or fitted
    EXPECT_GE(stated, 0.0);
  }
}

// The motion of the small bake is along one direction: one target holds it.
TEST_F(ExportTest, ABasisOfOneHoldsAMotionOfOne) {
  bake(true);
  const Glb glb = read_glb(write("all.glb", {}, 3));
  // From the rest pose, with weights within 0..1, it takes one to get to where the motion begins.
  EXPECT_NE(said_.find("2 morph targets"), std::string::npos) << said_;
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
  bake({-2, 0, 2, 4}, [](BakeFrame& frame) {
    for (auto& mesh : frame.positions) {
      for (std::size_t v = 0; v < mesh.size(); ++v) {
        mesh[v].z() += 0.01 * ((frame.frame * 37 + 11 * v) % 7);
      }
    }
    for (Vec3& p : frame.positions[2]) p = Vec3(1, 2, 3);  // the skin is one point and stands still
  });
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
