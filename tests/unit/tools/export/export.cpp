// SPDX-License-Identifier: Apache-2.0
//
// Point caches and sequences, read back by readers of the test's own: each number exactly.
#include "tests/unit/tools/export/export.h"

#include <gtest/gtest.h>

#include <sstream>

#include "rig/math.h"
#include "tools/export/sequence.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

TEST_F(ExportTest, Pc2HoldsEveryFrameAsFloats) {
  bake(true);
  ByteReader in{bytes_of(write("biceps.pc2", {"biceps"}))};
  EXPECT_EQ(in.bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  in.at = 12;
  EXPECT_EQ(in.take<std::int32_t>(), 1);
  EXPECT_EQ(in.take<std::int32_t>(), 4);
  EXPECT_EQ(in.take<float>(), -2.0f);
  EXPECT_EQ(in.take<float>(), 2.0f);  // every second frame
  EXPECT_EQ(in.take<std::int32_t>(), 4);
  for (int i = 0; i < 4; ++i) {
    for (const float value : as_floats(positions("biceps", i))) EXPECT_EQ(in.take<float>(), value);
  }
  EXPECT_EQ(in.at, in.bytes.size());
  EXPECT_NE(said_.find("Frame Start to -1, Frame Scale to 0.5"), std::string::npos) << said_;
  for (const char* fact :
       {"units: m", "up_axis: Y", "fps: 24", "first_frame: -2", "vertex_order"}) {
    EXPECT_NE(said_.find(fact), std::string::npos) << fact;
    EXPECT_NE(bytes_of(folder_ / "biceps.rest.obj").find(fact), std::string::npos) << fact;
  }
}

TEST_F(ExportTest, MddHoldsSecondsAndFloatsHighestByteFirst) {
  bake(false);
  options_.frames = "-2-0x2,4";
  ByteReader in{bytes_of(write("ulna.mdd", {"ulna"}))};
  EXPECT_NE(said_.find("Time Mode to Time, Frame Start to 0"), std::string::npos) << said_;
  EXPECT_EQ(in.take<std::int32_t>(true), 3);
  EXPECT_EQ(in.take<std::int32_t>(true), 4);
  for (const int frame : {-2, 0, 4})
    EXPECT_EQ(in.take<float>(true), static_cast<float>(frame / 24.0));
  for (const int i : {0, 1, 3}) {
    for (const float value : as_floats(positions("ulna", i)))
      EXPECT_EQ(in.take<float>(true), value);
  }
  EXPECT_EQ(in.at, in.bytes.size());
}

TEST_F(ExportTest, Pc2RefusesFramesAtUnevenSteps) {
  bake(false);
  options_.frames = "-2,0,4";
  expect_refused(ErrorCode::kUsage, "frame 4 breaks the step of 2", "ulna.pc2", {"ulna"});
}

/// What an OBJ file says, all numbers as doubles.
struct Obj {
  std::vector<std::string> names, groups, materials;
  std::vector<Vec3> v, vn;
  std::vector<std::array<float, 2>> vt;
  std::vector<Triangle> f, of_uvs;  // -1: without
};

Obj read_obj(const fs::path& file) {
  Obj obj;
  std::istringstream in(bytes_of(file));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "o") obj.names.push_back(line.substr(2));
    if (key == "g") obj.groups.push_back(line.substr(2));
    if (key == "usemtl") obj.materials.push_back(line.substr(7));
    if (key == "vt") {
      auto& uv = obj.vt.emplace_back();
      words >> uv[0] >> uv[1];
    }
    if (key == "v" || key == "vn") {
      Vec3 value;
      words >> value[0] >> value[1] >> value[2];
      (key == "v" ? obj.v : obj.vn).push_back(value);
    }
    if (key == "f") {
      Triangle& triangle = obj.f.emplace_back();
      Triangle& uvs = obj.of_uvs.emplace_back();
      for (int c = 0; c < 3; ++c) {
        std::string all, uv;
        words >> all;
        triangle[c] = std::stoi(all) - 1;
        const std::size_t first = all.find('/'), last = all.rfind('/');
        uv = all.substr(first + 1, last - first - 1);
        uvs[c] = uv.empty() ? -1 : std::stoi(uv) - 1;
        EXPECT_EQ(std::stoi(all.substr(last + 1)), triangle[c] + 1);
      }
    }
  }
  return obj;
}

TEST_F(ExportTest, ObjHoldsAllMeshesWithAllDigits) {
  for (const bool double_precision : {false, true}) {
    bake(double_precision);
    write("s/frame.###.obj", {});
    for (int i = 0; i < 4; ++i) {
      const char* numbers[] = {"-02", "000", "002", "004"};
      const Obj obj = read_obj(folder_ / "s" / (std::string("frame.") + numbers[i] + ".obj"));
      EXPECT_EQ(obj.names, (std::vector<std::string>{"biceps", "skin", "ulna"}));
      EXPECT_EQ(obj.groups, (std::vector<std::string>{"biceps muscle", "skin skin", "ulna bone"}));
      EXPECT_EQ(obj.materials, (std::vector<std::string>{"muscle", "skin", "bone"}));
      EXPECT_EQ(obj.vt[obj.of_uvs[0][2]], (std::array{static_cast<float>(0.1 / (2 * kPi) + 0.5),
                                                      0.5f}));  // the muscle's second vertex
      EXPECT_EQ(obj.of_uvs.back(), (Triangle{-1, -1, -1}));
      std::size_t vertex = 0, triangle = 0;
      for (const std::string& name : obj.names) {
        const std::size_t before = vertex;
        const std::vector<Vec3> baked = positions(name, i);
        const std::vector<Vec3> normals = vertex_normals({baked, mesh(name).rest.triangles});
        for (std::size_t v = 0; v < baked.size(); ++v, ++vertex) {
          ASSERT_LT(vertex, obj.v.size());
          // Floats are written with the digits of floats.
          if (double_precision) {
            EXPECT_EQ(obj.v[vertex], baked[v]);
          }
          EXPECT_EQ(obj.v[vertex].cast<float>(), baked[v].cast<float>());
          if (!normals[v].isZero()) {
            EXPECT_EQ(obj.vn[vertex].cast<float>(), normals[v].cast<float>());
          }
        }
        for (const Triangle& t : mesh(name).rest.triangles) {
          for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(obj.f[triangle][c], t[c] + static_cast<int>(before));
          }
          ++triangle;
        }
      }
      EXPECT_EQ(obj.v.size(), vertex);
      EXPECT_EQ(obj.vn.size(), vertex);
      EXPECT_EQ(obj.f.size(), triangle);
    }
  }
}

TEST_F(ExportTest, ObjSequenceHasOneLibraryOfMaterials) {
  bake(false);
  write("s/all.####.obj", {});
  EXPECT_NE(bytes_of(folder_ / "s/all.0002.obj").find("mtllib all.mtl\n"), std::string::npos);
  const std::string library = bytes_of(folder_ / "s/all.mtl");
  for (const char* name : {"newmtl muscle\nKd 0.55 0.12 0.1\n", "newmtl bone\n", "newmtl skin\n"}) {
    EXPECT_NE(library.find(name), std::string::npos) << name;
  }
  fs::create_directories(folder_ / "t");
  put_bytes(folder_ / "t/all.mtl", "mine");
  expect_refused(ErrorCode::kOutput, "not of Thew's making", "t/all.####.obj", {});
}

TEST_F(ExportTest, PlyHoldsPositionsNormalsAndVelocities) {
  for (const bool double_precision : {false, true}) {
    bake(double_precision);
    write("skin.ply", {"skin"});
    for (int i = 0; i < 4; ++i) {
      const char* numbers[] = {"-002", "0000", "0002", "0004"};
      ByteReader in{bytes_of(folder_ / (std::string("skin.") + numbers[i] + ".ply"))};
      const std::string end = "end_header\n";
      in.at = in.bytes.find(end) + end.size();
      const std::string header = in.bytes.substr(0, in.at);
      EXPECT_NE(header.find("element vertex 5\n"), std::string::npos) << header;
      EXPECT_NE(header.find("comment units: m\n"), std::string::npos) << header;
      const std::vector<Vec3> baked = positions("skin", i);
      const int before = std::max(i - 1, 0), after = std::min(i + 1, 3);
      const std::vector<Vec3> a = positions("skin", before), b = positions("skin", after);
      const double seconds = (info_.frames[after] - info_.frames[before]) / 24.0;
      for (std::size_t v = 0; v < 5; ++v) {
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_EQ(double_precision ? in.take<double>() : in.take<float>(), baked[v][axis]);
        }
        Eigen::Vector3f normal;
        for (int axis = 0; axis < 3; ++axis) normal[axis] = in.take<float>();
        EXPECT_NEAR(normal.norm(), 1.0f, 1e-6f);  // the last vertex is in no triangle
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_EQ(in.take<float>(), static_cast<float>((b[v][axis] - a[v][axis]) / seconds));
        }
      }
      for (const Triangle& triangle : mesh("skin").rest.triangles) {
        EXPECT_EQ(in.take<std::uint8_t>(), 3);
        for (const int vertex : triangle) EXPECT_EQ(in.take<std::int32_t>(), vertex);
      }
      EXPECT_EQ(in.at, in.bytes.size());
    }
  }
}

TEST_F(ExportTest, WhatItCannotWriteIsSaid) {
  bake(false);
  expect_refused(ErrorCode::kUsage, "--mesh: biceps, skin, ulna", "all.pc2", {});
  expect_refused(ErrorCode::kUsage, "did you mean \"biceps\"", "a.mdd", {"bicep"});
  expect_refused(ErrorCode::kUsage, "did you mean .usd", "a.usd", {});
  expect_refused(ErrorCode::kUsage, "--basis is for .glb", "a.usda", {}, 3);
  options_.frames = "0-2";
  expect_refused(ErrorCode::kUsage, "frame 1 is not in the bake", "a.glb", {});
  options_.frames = "";
  put_bytes(folder_ / "file", "");
  expect_refused(ErrorCode::kOutput, "file", "file/a.glb", {});
}

TEST_F(ExportTest, TheSameBytesAgain) {
  bake(false);
  for (const char* name : {"a.glb", "a.usda", "a.usdc", "a.usdz", "a.xdmf", "a.abc"}) {
    const std::string once = bytes_of(write(name, {}));
    EXPECT_FALSE(once.empty());
    EXPECT_EQ(bytes_of(write(name, {})), once) << name;
    EXPECT_FALSE(fs::exists(folder_ / (std::string(name) + ".tmp")));
  }
}

TEST(ExportSequence, TheLastRunOfMarksIsTheFrame) {
  EXPECT_EQ(sequence_file("d#/a.obj", 7), fs::path("d#/a.0007.obj"));
  EXPECT_EQ(sequence_file("a#b.###.obj", 12), fs::path("a#b.012.obj"));
  EXPECT_EQ(sequence_file("#.obj", 120), fs::path("120.obj"));
  EXPECT_EQ(sequence_file("a.####.obj", -2), fs::path("a.-002.obj"));
}

TEST_F(ExportTest, XdmfPointsToEachFramesPlaceInTheBake) {
  bake(true);
  options_.frames = "0,4";
  const std::string text = bytes_of(write("view/all.xdmf", {"skin"}));
  for (const char* part :
       {"<Time Value=\"0\"/>", "Value=\"0.16666666666666666\"", "Precision=\"8\"",
        "../bake.h5:/meshes/skin/positions|1 0 0:1 1 1:1 5 3:4 5 3<",
        "../bake.h5:/meshes/skin/positions|3 0 0:1 1 1:1 5 3:4 5 3<",
        "../bake.h5:/meshes/skin/triangles<"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

TEST_F(ExportTest, XdmfFindsTheBakeFromALinkedFolder) {
  bake(true);
  fs::create_directories(folder_ / "far/away");
  fs::create_directory_symlink(folder_ / "far/away", folder_ / "near");
  const std::string text = bytes_of(write("near/all.xdmf", {"skin"}));
  EXPECT_NE(text.find(">../../bake.h5:/meshes"), std::string::npos) << text;
}

TEST_F(ExportTest, XdmfRefusesAPathThatItCannotSay) {
  bake(true);
  fs::create_directories(folder_ / "a|b");
  fs::rename(folder_ / "bake.h5", folder_ / "a|b/bake.h5");
  options_.input = folder_ / "a|b/bake.h5";
  expect_refused(ErrorCode::kUsage, "a|b/bake.h5", "all.xdmf", {"skin"});
}

}  // namespace
}  // namespace thew::tests
