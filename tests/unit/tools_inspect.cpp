// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "tests/unit/sim_cache_bake.h"
#include "tools/inspect.h"

namespace thew {
namespace {

using nlohmann::json;
using InspectTest = CacheTest;

const char* const kTetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
    "f 1 3 2\nf 1 2 4\nf 2 3 4\n";

TEST_F(InspectTest, ASoundMesh) {
  put_bytes(folder_ / "a.obj", std::string(kTetrahedron) + "f 3 1 4\n");
  const Inspection found = inspect(folder_ / "a.obj", true);
  EXPECT_TRUE(found.sound) << found.text;
  const json read = json::parse(found.text);
  EXPECT_EQ(read.at("kind"), "mesh");
  EXPECT_EQ(read.at("vertices"), 4);
  EXPECT_EQ(read.at("triangles"), 4);
  EXPECT_NEAR(read.at("volume_m3").get<double>(), 1e-3 / 6, 1e-10);
  EXPECT_NEAR(read.at("highest_corner_m")[2].get<double>(), 0.1, 1e-8);
  EXPECT_TRUE(read.at("defects").empty());
}

TEST_F(InspectTest, AnOpenMeshSaysWhereAndWhatToDo) {
  put_bytes(folder_ / "a.obj", kTetrahedron);
  const Inspection found = inspect(folder_ / "a.obj", true);
  EXPECT_FALSE(found.sound);
  const json defects = json::parse(found.text).at("defects");
  ASSERT_EQ(defects.size(), 1u) << found.text;
  EXPECT_EQ(defects[0].at("count"), 3);
  EXPECT_FALSE(defects[0].at("first").get<std::string>().empty());
  const std::string text = inspect(folder_ / "a.obj", false).text;
  EXPECT_NE(text.find("not sound"), std::string::npos) << text;
  EXPECT_NE(text.find(defects[0].at("fix").get<std::string>()), std::string::npos) << text;
}

TEST_F(InspectTest, ARigNamesItsJoints) {
  put_bytes(folder_ / "a.urdf",
            "<robot name=\"r\"><link name=\"upper\"/><link name=\"lower\"/>"
            "<joint name=\"elbow\" type=\"revolute\"><parent link=\"upper\"/>"
            "<child link=\"lower\"/><axis xyz=\"0 0 1\"/>"
            "<limit lower=\"0\" upper=\"1.5707963267948966\" effort=\"1\" velocity=\"1\"/>"
            "</joint></robot>");
  const json bodies = json::parse(inspect(folder_ / "a.urdf", true).text).at("bodies");
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[0].at("body"), "upper");
  EXPECT_EQ(bodies[1].at("on"), "upper");
  EXPECT_EQ(bodies[1].at("joint"), "elbow");
  EXPECT_NEAR(bodies[1].at("range_deg")[1].get<double>(), 90.0, 1e-9);
}

TEST_F(InspectTest, ABakeIsMeasuredFromItsPositions) {
  BakeInfo info = small_info(true);
  BakeWriter writer(folder_, info, false);
  for (const int number : info.frames) {
    BakeFrame frame = small_frame(info, number);
    for (std::size_t m = 0; m < frame.positions.size(); ++m) {
      frame.positions[m] = info.meshes[m].rest.vertices;
    }
    // A tetrahedron of 1.25 times the height has 1.25 times the volume.
    if (number == 2) frame.positions[1][3].z() *= 1.25;
    writer.write(frame);
  }
  const std::string hash = writer.pack();
  const json read = json::parse(inspect(folder_ / "bake.h5", true).text);
  EXPECT_EQ(read.at("kind"), "bake");
  EXPECT_EQ(read.at("frames"), 4);
  EXPECT_EQ(read.at("hash"), hash);
  const json& biceps = read.at("meshes")[0];
  EXPECT_EQ(biceps.at("mesh"), "biceps");
  EXPECT_NEAR(biceps.at("max_volume_error").get<double>(), 0.25, 1e-12);
  EXPECT_EQ(biceps.at("at_frame"), 2);
  EXPECT_LT(read.at("meshes")[2].at("max_volume_error").get<double>(), 1e-15);
}

TEST_F(InspectTest, WhatIsNotThereIsAnError) {
  for (const char* name : {"none.obj", "none.urdf", "none.h5"}) {
    EXPECT_THROW(inspect(folder_ / name, false), Error) << name;
  }
}

}  // namespace
}  // namespace thew
