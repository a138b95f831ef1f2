// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "rig/character_import.h"
#include "rig/math.h"
#include "rig_temp.h"

namespace thew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A reader of glTF of its own, for what cesium_man.gltf has: one buffer in base64, one skin.
struct Gltf {
  Json json;
  std::string bytes;

  explicit Gltf(const fs::path& file) {
    std::ifstream in(file);
    json = Json::parse(in);
    const std::string uri = json["buffers"][0]["uri"];
    unsigned value = 0;
    int bits = 0;
    for (size_t i = uri.find(',') + 1; i < uri.size() && uri[i] != '='; ++i) {
      const std::string_view digits =
          "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
      value = value << 6 | static_cast<unsigned>(digits.find(uri[i]));
      bits += 6;
      if (bits < 8) continue;
      bits -= 8;
      bytes.push_back(static_cast<char>(value >> bits & 255));
    }
  }
  double at(int accessor, int item, int part) const {
    const Json& a = json["accessors"][accessor];
    const Json& view = json["bufferViews"][a["bufferView"].get<int>()];
    const std::map<std::string, int> widths = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
    const int type = a["componentType"], size = type == 5126 ? 4 : type == 5123 ? 2 : 1;
    const int stride = view.value("byteStride", size * widths.at(a["type"]));
    const char* from = bytes.data() + view.value("byteOffset", 0) + a.value("byteOffset", 0) +
                       item * stride + part * size;
    if (type == 5126) {
      float value;
      std::memcpy(&value, from, 4);
      return value;
    }
    if (type == 5123) {
      std::uint16_t value;
      std::memcpy(&value, from, 2);
      return value;
    }
    return static_cast<unsigned char>(*from);
  }
  int count(int accessor) const { return json["accessors"][accessor]["count"]; }

  Eigen::Matrix4d local(int node, double time) const {
    const Json& n = json["nodes"][node];
    if (n.contains("matrix")) {
      Eigen::Matrix4d m;
      for (int k = 0; k < 16; ++k) m(k % 4, k / 4) = n["matrix"][k];
      return m;
    }
    const auto list = [&](const char* key, std::vector<double> other) {
      return n.value(key, other);
    };
    std::map<std::string, std::vector<double>> of = {
        {"translation", list("translation", {0, 0, 0})},
        {"rotation", list("rotation", {0, 0, 0, 1})},
        {"scale", list("scale", {1, 1, 1})}};
    for (const Json& channel : json["animations"][0]["channels"]) {
      if (channel["target"]["node"] != node) continue;
      const Json& sampler = json["animations"][0]["samplers"][channel["sampler"].get<int>()];
      const int input = sampler["input"], output = sampler["output"];
      int k = 0;
      while (k + 2 < count(input) && at(input, k + 1, 0) <= time) ++k;
      const double u =
          std::clamp((time - at(input, k, 0)) / (at(input, k + 1, 0) - at(input, k, 0)), 0.0, 1.0);
      auto& value = of[channel["target"]["path"]];
      if (value.size() == 4) {
        const auto key = [&](int i) {
          return Eigen::Quaterniond(at(output, i, 3), at(output, i, 0), at(output, i, 1),
                                    at(output, i, 2))
              .normalized();
        };
        const Eigen::Quaterniond q = key(k).slerp(u, key(k + 1));
        value = {q.x(), q.y(), q.z(), q.w()};
        continue;
      }
      for (int p = 0; p < 3; ++p) {
        value[p] = (1 - u) * at(output, k, p) + u * at(output, k + 1, p);
      }
    }
    const auto& r = of["rotation"];
    Affine out = Affine::Identity();
    out.linear() = Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized().toRotationMatrix() *
                   Vec3(of["scale"].data()).asDiagonal();
    out.translation() = Vec3(of["translation"].data());
    return out.matrix();
  }
  Eigen::Matrix4d world(int node, double time) const {
    for (size_t p = 0; p < json["nodes"].size(); ++p) {
      for (const Json& child : json["nodes"][p].value("children", Json::array())) {
        if (child == node) return world(static_cast<int>(p), time) * local(node, time);
      }
    }
    return local(node, time);
  }
  std::vector<Vec3> skinned(double time) const {
    const Json& skin = json["skins"][0];
    std::vector<Eigen::Matrix4d> joints;
    for (size_t j = 0; j < skin["joints"].size(); ++j) {
      Eigen::Matrix4d bind;
      for (int k = 0; k < 16; ++k) {
        bind(k % 4, k / 4) = at(skin["inverseBindMatrices"], static_cast<int>(j), k);
      }
      joints.push_back(world(skin["joints"][j], time) * bind);
    }
    const Json& part = json["meshes"][0]["primitives"][0]["attributes"];
    std::vector<Vec3> out;
    for (int i = 0; i < count(part["POSITION"]); ++i) {
      Eigen::Vector4d p(at(part["POSITION"], i, 0), at(part["POSITION"], i, 1),
                        at(part["POSITION"], i, 2), 1.0);
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      double weights = 0.0;
      for (int k = 0; k < 4; ++k) {
        const double w = at(part["WEIGHTS_0"], i, k);
        sum += w * (joints[static_cast<int>(at(part["JOINTS_0"], i, k))] * p);
        weights += w;
      }
      out.push_back(sum.head<3>() / weights);
    }
    return out;
  }
};

fs::path shared(const char* name) { return fs::path(THEW_SHARED_DATA) / name; }

class BvhMotion : public TempFolder {};

TEST(Character, IsSkinnedAsTheFileSays) {
  const fs::path file = shared("cesium_man.gltf");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const Character character = import_character(file);
  const Gltf gltf(file);
  ASSERT_EQ(character.animations.size(), 1u);
  double worst = 0.0;
  for (double time : {0.0, 0.3, 0.777, 1.21, 2.0}) {
    std::vector<Affine> world;
    animated_bodies(character, character.animations[0], time, world);
    Rows x;
    skin_vertices(character.skin, character.mesh, world, x);
    const std::vector<Vec3> expected = gltf.skinned(time);
    ASSERT_EQ(x.size(), expected.size());  // and in the file's order
    for (size_t i = 0; i < x.size(); ++i) {
      worst = std::max(worst, (to_vec(x[i]) - expected[i]).norm());
    }
  }
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(worst, 0.0);
  RecordProperty("worst_m", std::to_string(worst));
  std::printf("worst distance from the file's own skinning: %g m\n", worst);
}

TEST(Character, BindPoseLeavesTheMeshAsItIs) {
  for (const char* name : {"cesium_man.gltf", "robot.glb"}) {
    const fs::path file = shared(name);
    if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
    const Character character = import_character(file);
    Rows x;
    skin_vertices(character.skin, character.mesh, character.bind, x);
    for (size_t i = 0; i < x.size(); ++i) {
      ASSERT_LT((to_vec(x[i]) - character.mesh.vertices[i]).norm(), 2e-6) << name << " " << i;
    }
    Pose pose;
    forward_kinematics(character.skeleton, std::vector<double>(character.skeleton.size(), 0.0),
                       pose);
    for (int b = 0; b < character.skeleton.size(); ++b) {
      EXPECT_LT((pose[b].translation() - character.bind[b].translation()).norm(), 1e-12);
    }
  }
}

TEST(Character, ScaleScalesAllOfIt) {
  const fs::path file = shared("robot.glb");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const Character one = import_character(file), half = import_character(file, 0.5);
  std::vector<Affine> a, b;
  animated_bodies(one, one.animations[3], 0.4, a);
  animated_bodies(half, half.animations[3], 0.4, b);
  Rows x, y;
  skin_vertices(one.skin, one.mesh, a, x);
  skin_vertices(half.skin, half.mesh, b, y);
  for (size_t i = 0; i < x.size(); ++i) {
    ASSERT_LT((0.5 * to_vec(x[i]) - to_vec(y[i])).norm(), 1e-12);
  }
  EXPECT_FALSE(one.warnings.empty());  // it is 4.5 m high
}

TEST(Character, BlendsBetweenPosesAndKeepsItsEnds) {
  const fs::path file = shared("robot.glb");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const Character robot = import_character(file);
  std::vector<Affine> end, world;
  animated_bodies(robot, robot.animations[0], 0.5, end);
  blend_bodies(robot.skeleton, robot.bind, end, 0.0, world);
  for (size_t b = 0; b < world.size(); ++b) {
    EXPECT_LT((world[b].matrix() - robot.bind[b].matrix()).norm(), 1e-5);
  }
  blend_bodies(robot.skeleton, robot.bind, end, 1.0, world);
  for (size_t b = 0; b < world.size(); ++b) {
    EXPECT_LT((world[b].matrix() - end[b].matrix()).norm(), 1e-5);
  }
}

TEST_F(BvhMotion, IsReadInSecondsAndCarriedOverByNames) {
  // Two joints; the second turns by 90 degrees about x (BVH: Xrotation) in the second frame.
  const fs::path file = write("a.bvh",
                              "HIERARCHY\nROOT Arm\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition "
                              "Yposition Zposition Zrotation Yrotation Xrotation\n JOINT "
                              "Fore\n {\n  OFFSET 0 -1 0\n  CHANNELS 3 Zrotation Yrotation "
                              "Xrotation\n  End Site\n  {\n   OFFSET 0 -1 0\n  }\n }\n}\n"
                              "MOTION\nFrames: 2\nFrame Time: 0.5\n0 0 0 0 0 0 0 0 0\n0 0 0 "
                              "0 0 0 0 0 90\n");
  const Character motion = import_character(file);
  ASSERT_EQ(motion.animations.size(), 1u);
  EXPECT_NEAR(motion.animations[0].duration, 0.5, 1e-9);
  Character other = motion;  // of other names
  for (std::string& name : other.skeleton.body_names) name = "my_" + name;
  std::vector<std::string> warnings;
  const BodyClip clip = retarget(motion, motion.animations[0], other,
                                 {{{"Arm", "my_Arm"}, {"Fore", "my_Fore"}}}, "x", warnings);
  std::vector<Affine> world;
  animated_bodies(other, clip, 0.25, world);
  const int fore = find_body(other.skeleton, "my_Fore");
  ASSERT_GE(fore, 0);
  const Vec3 down = world[fore].linear() * Vec3(0, -1, 0);
  EXPECT_LT((down - rotation_about(Vec3::UnitX(), 45 * kDegree) * Vec3(0, -1, 0)).norm(), 1e-6);
  EXPECT_THROW(retarget(motion, motion.animations[0], other, {{{"Arm", "Elbow"}}}, "x", warnings),
               Error);
  EXPECT_THROW(retarget(motion, motion.animations[0], other, {}, "x", warnings), Error);
}

}  // namespace
}  // namespace thew
