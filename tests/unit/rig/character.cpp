// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// An independent reader of glTF, for what cesium_man.gltf has: one buffer in base64, one skin.
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
  // Appendix C of glTF 2.0: with t from 0 to 1 between keys v_k, v_k+1 that are t_d apart, b_k the
  // out-tangent and a_k+1 the in-tangent,
  //   v = (2t^3 - 3t^2 + 1) v_k + t_d (t^3 - 2t^2 + t) b_k + (-2t^3 + 3t^2) v_k+1
  //       + t_d (t^3 - t^2) a_k+1.
  std::vector<double> bent(int output, int k, int keys, double t, double t_d, int width,
                           bool step) const {
    std::vector<double> value;
    for (int p = 0; p < width; ++p) {
      if (step) {
        value.push_back(at(output, t < 1.0 ? k : keys - 1, p));
        continue;
      }
      const double v_k = at(output, 3 * k + 1, p), b_k = at(output, 3 * k + 2, p);
      const double a_next = at(output, 3 * k + 3, p), v_next = at(output, 3 * k + 4, p);
      const double t2 = t * t, t3 = t2 * t;
      value.push_back((2 * t3 - 3 * t2 + 1) * v_k + t_d * (t3 - 2 * t2 + t) * b_k +
                      (-2 * t3 + 3 * t2) * v_next + t_d * (t3 - t2) * a_next);
    }
    return value;
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
      const std::string way = sampler.value("interpolation", "LINEAR");
      if (way != "LINEAR") {
        value = bent(output, k, count(input), u, at(input, k + 1, 0) - at(input, k, 0),
                     static_cast<int>(value.size()), way == "STEP");
        continue;
      }
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

fs::path made_up(const char* name) {
  return fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure" / name;
}

class BvhMotion : public TempFolder {};

// m, over all vertices and times.
double worst_against(const fs::path& file, const std::vector<double>& times) {
  const Character character = import_character(file);
  const Gltf gltf(file);
  EXPECT_EQ(character.animations.size(), 1u);
  double worst = 0.0;
  for (double time : times) {
    std::vector<Affine> world;
    animated_bodies(character, character.animations[0], time, world);
    Points x;
    skin_vertices(character.skin, character.mesh, world, x);
    const std::vector<Vec3> expected = gltf.skinned(time);
    EXPECT_EQ(x.size(), expected.size());  // and in the file's order
    for (size_t i = 0; i < x.size(); ++i) {
      worst = std::max(worst, (to_vec(x[i]) - expected[i]).norm());
    }
  }
  std::printf("%s: worst distance from the file's own skinning: %g m\n", file.filename().c_str(),
              worst);
  return worst;
}

TEST(Character, IsSkinnedAsTheFileSays) {
  const fs::path file = shared("cesium_man.gltf");
  if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
  const double worst = worst_against(file, {0.0, 0.3, 0.777, 1.21, 2.0});
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(worst, 0.0);
}

// Before, at, between and after the keys at 0, 0.5, 1.25 and 2 s, or at 0.25 and 1.75 s.
TEST(Character, CurvesGoAsTheFormatSays) {
  std::vector<double> times = {-0.3, 2.0, 2.7};
  for (double time = 0.0; time < 2.0; time += 0.0625) times.push_back(time);
  EXPECT_LT(worst_against(made_up("figure.gltf"), times), 1e-6);
  EXPECT_TRUE(import_character(made_up("figure.gltf")).warnings.empty());
}

TEST(Character, ACubicByHand) {
  Curve<Vec3> curve;
  curve.times = {1.0, 3.0};
  curve.values = {Vec3(1, 0, 2), Vec3(5, 0, 2)};
  curve.interpolation = CurveInterpolation::kCubic;
  curve.slopes_in = {Vec3(9, 9, 9), Vec3(-4, 1, 0)};
  curve.slopes_out = {Vec3(2, 3, 0), Vec3(9, 9, 9)};
  Vec3 value;
  // At a half: 0.5 v0 + 2 * 0.125 b0 + 0.5 v1 - 2 * 0.125 a1.
  sample(curve, 2.0, value);
  EXPECT_LT((value - Vec3(0.5 + 0.5 + 2.5 + 1.0, 0.75 - 0.25, 2.0)).norm(), 1e-15);
  // At a quarter: 54/64 v0 + 2 * 9/64 b0 + 10/64 v1 - 2 * 3/64 a1.
  sample(curve, 1.5, value);
  EXPECT_LT((64.0 * value - Vec3(54 + 36 + 50 + 24, 54 - 6, 128)).norm(), 1e-13);
  sample(curve, 0.5, value);
  EXPECT_EQ(value, Vec3(1, 0, 2));
  sample(curve, 3.0, value);
  EXPECT_EQ(value, Vec3(5, 0, 2));
  curve.interpolation = CurveInterpolation::kStep;
  sample(curve, 2.999, value);
  EXPECT_EQ(value, Vec3(1, 0, 2));
  sample(curve, 3.0, value);
  EXPECT_EQ(value, Vec3(5, 0, 2));
}

class BentCurves : public TempFolder {};

// Buffers beside the file and in a .glb. A curve that cannot be read is reported, and the others
// are read.
TEST_F(BentCurves, FromEveryKindOfBuffer) {
  Gltf gltf(made_up("figure.gltf"));
  const BodyClip expected = import_character(made_up("figure.gltf")).animations[0];
  const auto same = [&](const fs::path& file) {
    const Character read = import_character(file);
    EXPECT_TRUE(read.warnings.empty()) << file;
    ASSERT_EQ(read.animations[0].tracks.size(), expected.tracks.size());
    for (const BodyTrack& track : read.animations[0].tracks) {
      for (const BodyTrack& other : expected.tracks) {
        if (other.body != track.body) continue;
        EXPECT_EQ(track.rotation.interpolation, other.rotation.interpolation);
        EXPECT_EQ(track.translation.interpolation, other.translation.interpolation);
        EXPECT_EQ(track.scale.slopes_in, other.scale.slopes_in);
      }
    }
  };
  gltf.json["buffers"][0]["uri"] = "figure.bin";
  write("figure.bin", gltf.bytes);
  same(write("figure.gltf", gltf.json.dump()));
  gltf.json["buffers"][0].erase("uri");
  std::string text = gltf.json.dump();
  text.append(text.size() % 4 == 0 ? 0 : 4 - text.size() % 4, ' ');
  const auto word = [](size_t value) {
    std::string out;
    for (int k = 0; k < 4; ++k) out.push_back(static_cast<char>(value >> 8 * k & 255));
    return out;
  };
  same(write("figure.glb", "glTF" + word(2) + word(12 + 8 + text.size() + 8 + gltf.bytes.size()) +
                               word(text.size()) + "JSON" + text + word(gltf.bytes.size()) +
                               std::string("BIN\0", 4) + gltf.bytes));
  gltf.json["buffers"][0]["uri"] = "figure.bin";
  gltf.json["animations"][0]["samplers"][1]["interpolation"] = "WAVY";
  const Character odd = import_character(write("odd.gltf", gltf.json.dump()));
  ASSERT_EQ(odd.warnings.size(), 1u);
  EXPECT_HAS(odd.warnings[0], ": 1 animated curves");
}

TEST(Character, BindPoseLeavesTheMeshAsItIs) {
  for (const char* name : {"cesium_man.gltf", "robot.glb"}) {
    const fs::path file = shared(name);
    if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
    const Character character = import_character(file);
    Points x;
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
  Points x, y;
  skin_vertices(one.skin, one.mesh, a, x);
  skin_vertices(half.skin, half.mesh, b, y);
  for (size_t i = 0; i < x.size(); ++i) {
    ASSERT_LT((0.5 * to_vec(x[i]) - to_vec(y[i])).norm(), 1e-12);
  }
  EXPECT_FALSE(one.size_doubt.empty());  // it is 4.5 m high
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

// glTF 2.0, 3.7.3.3: joints, inverse bind matrices and weights alone place a skinned mesh.
class SkinnedNode : public TempFolder {
 protected:
  Json figure() const {
    std::ifstream in(fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf");
    return Json::parse(in);
  }
  int skinned(const Json& json) const {
    const Json& nodes = json["nodes"];
    for (size_t i = 0; i < nodes.size(); ++i) {
      if (nodes[i].contains("skin")) return static_cast<int>(i);
    }
    return -1;
  }
  Character read(const Json& json, double scale = 1.0) const {
    return import_character(write("moved.gltf", json.dump()), scale);
  }
  static void expect_same(const Character& a, const Character& b) {
    ASSERT_EQ(a.mesh.vertices.size(), b.mesh.vertices.size());
    for (size_t i = 0; i < a.mesh.vertices.size(); ++i) {
      ASSERT_LT((a.mesh.vertices[i] - b.mesh.vertices[i]).norm(), 1e-9) << i;
    }
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
    for (int one = 0; one < a.skeleton.size(); ++one) {
      const std::string& name = a.skeleton.body_names[one];
      const int other = find_body(b.skeleton, name);
      if (other < 0 || name == "Figure") continue;
      EXPECT_LT((a.bind[one].matrix() - b.bind[other].matrix()).norm(), 1e-9) << name;
    }
  }
};

TEST_F(SkinnedNode, ItsTransformIsIgnored) {
  const Json plain = figure();
  const int mesh = skinned(plain);
  ASSERT_GE(mesh, 0);
  const std::vector<std::pair<const char*, Json>> transforms = {
      {"scale", {0.01, 0.01, 0.01}},
      {"rotation", {-0.7071067811865476, 0, 0, 0.7071067811865476}},
      {"translation", {1, 2, 3}},
      {"scale", {-1, 1, 1}}};  // mirrored: no triangle turns over
  for (const auto& [kind, value] : transforms) {
    SCOPED_TRACE(kind);
    Json moved = plain;
    moved["nodes"][mesh][kind] = value;
    expect_same(read(plain), read(moved));
    expect_same(read(plain, 0.4), read(moved, 0.4));
  }
}

// A glTF as Blender writes it for a character that was imported from FBX: the mesh is a child of
// the armature, which has the scale to centimetres and a rotation, or of the root of the scene,
// which is the same by the specification.
TEST_F(SkinnedNode, ItMayHangAnywhere) {
  const Json plain = figure();
  const int mesh = skinned(plain);
  Json hung = plain;
  hung["nodes"].push_back({{"name", "Armature"},
                           {"scale", {0.01, 0.01, 0.01}},
                           {"rotation", {-0.7071067811865476, 0, 0, 0.7071067811865476}},
                           {"children", {mesh}}});
  hung["scenes"][0]["nodes"] = {0, hung["nodes"].size() - 1};
  expect_same(read(plain), read(hung));
}

// Of a joint that twists by half a turn, halfway between its bodies: the blend flattens to a line.
TEST(Blend, IsInvertedAsFarAsItCanBe) {
  const auto blend = [](double angle) -> Mat3 {
    return 0.5 * (Mat3::Identity() + rotation_about(Vec3::UnitY(), angle));
  };
  for (const double degrees : {0.0, 45.0, 90.0}) {
    const Mat3 by = blend(degrees * kDegree);
    EXPECT_LT((bounded_inverse(by) * by - Mat3::Identity()).norm(), 1e-14) << degrees;
  }
  for (const double degrees : {175.0, 179.9999, 180.0}) {
    const Mat3 inverse = bounded_inverse(blend(degrees * kDegree));
    ASSERT_TRUE(inverse.allFinite());
    EXPECT_NEAR(inverse.norm(), std::sqrt(20.0 * 20.0 + 20.0 * 20.0 + 1.0), 1e-9) << degrees;
    EXPECT_LT((inverse * Vec3::UnitY() - Vec3::UnitY()).norm(), 1e-12);  // along the axis
  }
}

}  // namespace
}  // namespace thew::tests
