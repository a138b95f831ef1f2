// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "sim/bake/measure.h"
#include "tests/unit/sim/cache_bake.h"
#include "tests/unit/skin/shapes.h"
#include "tools/cli/inspect_command.h"
#include "tools/inspect/crossings.h"
#include "tools/inspect/exact_predicates.h"

namespace thew::tests {
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

// What a scene's clip takes has no mesh, and is no failed character.
TEST_F(InspectTest, AMotionNamesItsBodiesAndAnimations) {
  put_bytes(folder_ / "a.bvh",
            "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
            "JOINT Spine\n{\nOFFSET 0 10 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
            "End Site\n{\nOFFSET 0 10 0\n}\n}\n}\n"
            "MOTION\nFrames: 3\nFrame Time: 0.5\n0 0 0 0 0 0\n0 0 0 9 0 0\n0 0 0 0 0 0\n");
  put_bytes(folder_ / "b.gltf", R"({"asset":{"version":"2.0"},"nodes":[{"name":"arm"}],
    "scenes":[{"nodes":[0]}],"scene":0,"buffers":[{"byteLength":40,"uri":"data:;base64,)"
                                R"(AAAAAAAAAEAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAA=="}],
    "bufferViews":[{"buffer":0,"byteLength":40}],"accessors":[
    {"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[2]},
    {"bufferView":0,"byteOffset":8,"componentType":5126,"count":2,"type":"VEC4"}],
    "animations":[{"name":"wave","channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}],
    "samplers":[{"input":0,"output":1}]}]})");
  for (const auto& [file, seconds] : {std::pair("a.bvh", 1.0), {"b.gltf", 2.0}}) {
    const Inspection found = inspect(folder_ / file, true);
    EXPECT_TRUE(found.sound);
    const json read = json::parse(found.text);
    EXPECT_EQ(read.at("kind"), "motion");
    EXPECT_FALSE(read.contains("triangles"));
    EXPECT_EQ(read.at("bodies")[0].at("body"), seconds == 1.0 ? "Hips" : "arm");
    ASSERT_EQ(read.at("animations").size(), 1u);
    EXPECT_NEAR(read.at("animations")[0].at("seconds").get<double>(), seconds, 1e-6);
  }
}

// Nothing is skinned where rigid pieces hang on bodies, which an arm's names tell.
TEST_F(InspectTest, PiecesOnAnArmAreACharacter) {
  for (const char* name : {"RightForeArm", "Lid"}) {
    put_bytes(
        folder_ / "a.gltf",
        R"({"asset":{"version":"2.0"},"nodes":[{"name":"RightArm","mesh":0,"children":[1]},
    {"name":")" +
            std::string(name) +
            R"(","mesh":0,"translation":[0.3,0,0]}],
    "scenes":[{"nodes":[0]}],"scene":0,"buffers":[{"byteLength":36,"uri":"data:;base64,)"
            R"(AAAAAAAAAAAAAAAAzczMPQAAAAAAAAAAAAAAAM3MzD0AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],
    "max":[0.1,0.1,0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})");
    const json read = json::parse(inspect(folder_ / "a.gltf", true).text);
    EXPECT_EQ(read.at("kind"), std::string(name) == "Lid" ? "mesh" : "character");
  }
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
  EXPECT_NEAR(biceps.at("max_volume_error_written").get<double>(), 0.25, 1e-12);
  EXPECT_EQ(biceps.at("at_frame"), 2);
  EXPECT_LT(read.at("meshes")[2].at("max_volume_error_written").get<double>(), 1e-15);
  EXPECT_EQ(read.at("volume_error_note"), "as written, float64");
}

// Rounding alone makes an error, and it is not the solver's.
TEST_F(InspectTest, VolumeErrorsOfFloat32AreSaidToBeSo) {
  BakeInfo info = small_info(false);
  info.frames = {1};
  BakeWriter writer(folder_, info, false);
  BakeFrame frame = small_frame(info, 1);
  for (std::size_t m = 0; m < frame.positions.size(); ++m) {
    frame.positions[m] = info.meshes[m].rest.vertices;
  }
  writer.write(frame);
  writer.pack();
  const Inspection found = inspect(folder_ / "bake.h5", true);
  const json read = json::parse(found.text);
  const double error = read.at("meshes")[0].at("max_volume_error_written");
  EXPECT_GT(error, 1e-9);
  EXPECT_EQ(error, written_volume_error(info.meshes[1], frame.positions[1], false));
  EXPECT_LT(written_volume_error(info.meshes[1], frame.positions[1], true), 1e-15);
  const std::string text = inspect(folder_ / "bake.h5", false).text;
  EXPECT_NE(text.find("max volume error written"), std::string::npos) << text;
  EXPECT_NE(text.find("as written, float32"), std::string::npos) << text;
}

void put_obj(const std::filesystem::path& file, const TriMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& p : mesh.vertices) text << "v " << p.transpose() << "\n";
  for (const Triangle& t : mesh.triangles) {
    text << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  }
  put_bytes(file, text.str());
}

// A ball pulled through itself: closed, oriented, one piece, and its inside is not defined.
TEST_F(InspectTest, AMeshThatCrossesItselfIsNotSound) {
  TriMesh mesh = ball(0.1, Vec3::Zero(), 24, 23);
  put_obj(folder_ / "calm.obj", mesh);
  const Inspection calm = inspect(folder_ / "calm.obj", true);
  EXPECT_TRUE(calm.sound) << calm.text;
  for (Vec3& p : mesh.vertices) {
    if (p.x() > 0.09) p.x() -= 0.197;
  }
  put_obj(folder_ / "through.obj", mesh);
  const Inspection through = inspect(folder_ / "through.obj", true);
  EXPECT_FALSE(through.sound);
  const json defects = json::parse(through.text).at("defects");
  ASSERT_FALSE(defects.empty()) << through.text;
  EXPECT_EQ(defects.back().at("defect"), "self-intersection, pairs of triangles");
  int pairs = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = i + 1; k < mesh.triangles.size(); ++k) {
      const Triangle &s = mesh.triangles[i], &t = mesh.triangles[k];
      const auto& x = mesh.vertices;
      pairs += std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) == s.end() &&
               triangles_meet({x[s[0]], x[s[1]], x[s[2]]}, {x[t[0]], x[t[1]], x[t[2]]});
    }
  }
  EXPECT_EQ(find_self_crossings(mesh).pairs, pairs);
  EXPECT_GT(defects.back().at("count"), 20);  // of the file, whose reader rounds to float32
  EXPECT_NE(defects.back().at("first").get<std::string>().find(" at ("), std::string::npos);
}

// Where each triangle lies in all others, looking is given up in time, and that is said.
TEST_F(InspectTest, AHeapOfTrianglesEndsInTime) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-0.1, 0.1);
  TriMesh heap;
  for (int i = 0; i < 60000; ++i) {
    heap.vertices.emplace_back(anywhere(random), anywhere(random), anywhere(random));
    if (i % 3 == 2) heap.triangles.push_back({i - 2, i - 1, i});
  }
  const SelfCrossings found = find_self_crossings(heap);
  EXPECT_FALSE(found.all);
  EXPECT_GT(found.pairs, 1000);
}

TEST_F(InspectTest, WhatIsNotThereIsAnError) {
  for (const char* name : {"none.obj", "none.urdf", "none.h5"}) {
    EXPECT_THROW(inspect(folder_ / name, false), Error) << name;
  }
}

}  // namespace
}  // namespace thew::tests
