// SPDX-License-Identifier: Apache-2.0
//
// Maps by node: however they are given, and what they move.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "rig/text.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

// A box of flesh that hangs from a body: its mesh is of 98 nodes, and stands in a PLY and a glTF
// with what is painted on it.
class Maps : public TempFolder {
 protected:
  void SetUp() override {
    TempFolder::SetUp();
    write("rig.urdf", "<robot name=\"r\"><link name=\"top\"/></robot>");
    const int n = 5;  // nodes along an edge
    std::map<std::array<int, 3>, int> index;
    const auto node = [&](std::array<int, 3> at) {
      const auto [found, fresh] = index.emplace(at, static_cast<int>(index.size()));
      if (fresh) mesh_.vertices.emplace_back(0.01 * at[0] + 0.02, 0.02 * at[1], 0.01 * at[2]);
      return found->second;
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < n; side += n - 1) {
        for (int a = 0; a + 1 < n; ++a) {
          for (int b = 0; b + 1 < n; ++b) {
            const auto corner = [&](int i, int j) {
              std::array<int, 3> at;
              at[axis] = side, at[(axis + 1) % 3] = i, at[(axis + 2) % 3] = j;
              return node(at);
            };
            const int p = corner(a, b), q = corner(a + 1, b), r = corner(a + 1, b + 1),
                      s = corner(a, b + 1);
            const bool out = side > 0;
            mesh_.triangles.push_back(out ? Triangle{p, q, r} : Triangle{p, r, q});
            mesh_.triangles.push_back(out ? Triangle{p, r, s} : Triangle{p, s, r});
          }
        }
      }
    }
    for (const Vec3& p : mesh_.vertices) values_.push_back(p.y() < 0.04 ? 0.25 : 0.75);
    write("flesh.ply", ply());
    write("flesh.gltf", gltf());
  }

  std::string ply() const {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                       std::to_string(mesh_.vertices.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                       "soft\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                       "element face " +
                       std::to_string(mesh_.triangles.size()) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
    for (size_t i = 0; i < mesh_.vertices.size(); ++i) {
      const Vec3& p = mesh_.vertices[i];
      char line[128];
      std::snprintf(line, sizeof line, "%.9g %.9g %.9g %.9g %d 0 0\n", p.x(), p.y(), p.z(),
                    values_[i], values_[i] > 0.5 ? 255 : 0);
      text += line;
    }
    for (const Triangle& t : mesh_.triangles) {
      text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " +
              std::to_string(t[2]) + "\n";
    }
    return text;
  }

  // With the buffer in a file beside it.
  std::string gltf() const {
    std::string bytes;
    const auto add = [&](const auto& number) {
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    for (const Vec3& p : mesh_.vertices) {
      for (int k = 0; k < 3; ++k) add(static_cast<float>(p[k]));
    }
    for (const double value : values_) add(static_cast<float>(value));
    for (const Triangle& t : mesh_.triangles) {
      for (const int i : t) add(static_cast<std::uint32_t>(i));
    }
    write("flesh.bin", bytes);
    const std::string n = std::to_string(mesh_.vertices.size());
    const std::string corners = std::to_string(3 * mesh_.triangles.size());
    const size_t a = 12 * mesh_.vertices.size(), b = a + 4 * mesh_.vertices.size();
    const auto view = [](size_t from, size_t to) {
      return "{\"buffer\":0,\"byteOffset\":" + std::to_string(from) +
             ",\"byteLength\":" + std::to_string(to - from) + "}";
    };
    return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
           "\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"_THEW_"
           "SOFT\":1},\"indices\":2}]}],\"buffers\":[{\"uri\":\"flesh.bin\",\"byteLength\":" +
           std::to_string(bytes.size()) + "}],\"bufferViews\":[" + view(0, a) + "," + view(a, b) +
           "," + view(b, bytes.size()) +
           "],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":" + n +
           ",\"type\":\"VEC3\",\"min\":[0.02,0,0],\"max\":[0.06,0.08,0.04]},{\"bufferView\":1,"
           "\"componentType\":5126,\"count\":" +
           n +
           ",\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5125,\"count\":" + corners +
           ",\"type\":\"SCALAR\"}]}";
  }

  std::string scene(const std::string& stiffness, const std::string& more = "",
                    const std::string& file = "flesh.ply") const {
    return "[scene]\nfps = 24\nsettle = 0\nframes = \"1-4\"\ngravity = [0, 0, 0]\n[rig]\nfile = "
           "\"rig.urdf\"\n[[muscle]]\nname = \"flesh\"\nmesh = \"" +
           file +
           "\"\nfixed = [{ body = \"top\", low = [-1, 0.079, -1] }]\nmaterial = { bending = 0, "
           "anisotropy = 1, stiffness = " +
           stiffness + " }\n" + more;
  }
  Model with(const std::string& stiffness, const std::string& more = "",
             const std::string& file = "flesh.ply") const {
    return build_model(read_scene(write("scene.toml", scene(stiffness, more, file))));
  }
  std::string numbers(double low, double high) const {
    std::string text;
    for (const double value : values_) {
      text += (text.empty() ? "" : ", ") + number_text(value > 0.5 ? high : low);
    }
    return text;
  }
  std::string error_of(const std::string& stiffness) const {
    try {
      with(stiffness);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  TriMesh mesh_;
  std::vector<double> values_;  // as painted
};

TEST_F(Maps, EachWayToGiveOneGivesTheSame) {
  const Model plain = with("1000");
  const Model listed = with("{ list = [" + numbers(500, 1500) + "] }");
  const std::vector<double>& expected = listed.muscles[0].springs.stiffness;
  for (size_t k = 0; k < expected.size(); ++k) {  // by the mean of the two nodes
    const auto& [a, b] = plain.muscles[0].springs.nodes[k];
    EXPECT_NEAR(expected[k] / plain.muscles[0].springs.stiffness[k], values_[a] + values_[b], 1e-6);
  }
  std::string by_order, by_place;
  for (size_t i = 0; i < values_.size(); ++i) {
    const std::string value = number_text(2000 * values_[i]);
    const Vec3& p = mesh_.vertices[values_.size() - 1 - i];
    by_order += value + "\n";
    char line[128];
    std::snprintf(line, sizeof line, "%.9g %.9g %.9g %.9g\n", p.x(), p.y(), p.z(),
                  2000 * values_[values_.size() - 1 - i]);
    by_place += line;
  }
  write("order.txt", by_order);
  write("place.txt", by_place);
  for (const char* way :
       {"{ file = \"order.txt\" }", "{ file = \"place.txt\" }",
        "{ attribute = \"soft\", scale = [0, 2000] }",
        "{ attribute = \"soft\", file = \"flesh.ply\", scale = [0, 2000] }",
        "{ attribute = \"_THEW_SOFT\", file = \"flesh.gltf\", scale = [0, 2000] }",
        "{ colour = \"red\", scale = [500, 1500] }",
        "{ colour = \"red\", file = \"flesh.ply\", scale = [500, 1500] }"}) {
    EXPECT_EQ(with(way).muscles[0].springs.stiffness, expected) << way;
  }
  EXPECT_EQ(with("{ attribute = \"_THEW_SOFT\", scale = [0, 2000] }", "", "flesh.gltf")
                .muscles[0]
                .springs.stiffness,
            expected);
}

TEST_F(Maps, PlacesFadeFromTheirMiddleToTheBase) {
  const Model model = with("{ places = [[0.02, 0, 0, 0.03, 400]], base = 1000 }");
  const MuscleDef def = define_model(read_scene(folder / "scene.toml")).muscles[0];
  for (size_t i = 0; i < mesh_.vertices.size(); ++i) {
    const double far = (mesh_.vertices[i] - Vec3(0.02, 0, 0)).norm();
    if (far < 1e-9) {
      EXPECT_NEAR(def.stiffness[i], 400, 1e-6);
    } else if (far > 0.03) {
      EXPECT_EQ(def.stiffness[i], 1000);
    }
    if (std::abs(far - 0.01) < 1e-6) {  // smoothstep of a third is 7/27
      EXPECT_NEAR(def.stiffness[i], 1000 - 600 * (1 - 7.0 / 27), 1e-3);
    }
  }
}

TEST_F(Maps, AConstantOneIsItsNumber) {
  const std::string number = with("700").hash;
  EXPECT_EQ(with("{ list = [" + numbers(700, 700) + "] }").hash, number);
  EXPECT_EQ(with("{ places = [[0, 0, 0, 0.05, 700]], base = 700 }").hash, number);
  EXPECT_NE(with("{ list = [" + numbers(700, 701) + "] }").hash, number);
  // Nor does the way through the nodes round.
  const Model plain = with("700");
  const std::vector<double> by_node(mesh_.vertices.size(), 700.0);
  EXPECT_EQ(make_springs(plain.muscles[0].rest, {}, plain.muscles[0].settings.material, by_node)
                .stiffness,
            plain.muscles[0].springs.stiffness);
}

// m, the farthest that a gravity of 0.5 m/s^2 moves a node, at rest.
double sag(const Model& model) {
  std::vector<Points> x;
  for (const double gravity : {0.0, 0.5}) {
    Model pulled = model;
    pulled.gravity = Vec3(0, 0, -gravity);
    Parallel one(1);
    State state = initial_state(pulled);
    StageSeconds seconds;
    for (int f = 1; f <= 60; ++f) step_frame(pulled, f / pulled.fps, one, state, seconds);
    EXPECT_EQ(state.muscles[0].ladder.frame_rung, Rung::kNone);
    x.push_back(state.muscles[0].x);
  }
  return largest_distance(x[0], x[1]);
}

// Held at both ends, and by nothing else but its springs. Their shape term has no buckling, so that
// all is linear: displacement goes by load over stiffness.
TEST_F(Maps, HalfTheStiffnessGivesWayTwiceAsFar) {
  const auto sag_with = [&](const std::string& stiffness) {
    std::string text = scene(stiffness, "guide = 0\ndamping = 30\n[solver]\niterations = 30\n");
    const std::string fixed = "fixed = [{ body = \"top\", low = [-1, 0.079, -1] }]";
    text.replace(text.find(fixed), fixed.size(),
                 "path = [[\"top\", 0.04, 0.1, 0.02], [\"top\", 0.04, -0.02, 0.02]]\n"
                 "belly = [0.025, 0.095]");
    return sag(build_model(read_scene(write("scene.toml", text))));
  };
  const double plain = sag_with("2000");
  const double half = sag_with("{ list = [" + numbers(1000, 1000.0001) + "] }");
  const double below = sag_with("{ list = [" + numbers(1000, 2000) + "] }");
  EXPECT_GT(plain, 1e-6);
  EXPECT_NEAR(half / plain, 2.0, 0.02);
  EXPECT_GT(below, 1.05 * plain);
  EXPECT_LT(below, 0.95 * half);
}

TEST_F(Maps, AMirroredMuscleTakesItsMapsWithIt) {
  const std::string places = "{ places = [[0.02, 0, 0, 0.03, 400]], base = 1000 }";
  const std::string fixed = "mirror = true\n";
  const Model here = with(places), there = with(places, fixed);
  const Muscle &a = here.muscles[0], &b = there.muscles[0];
  ASSERT_EQ(a.rest.vertices.size(), b.rest.vertices.size());
  for (size_t i = 0; i < a.rest.vertices.size(); ++i) {
    const Vec3& p = a.rest.vertices[i];
    EXPECT_EQ(b.rest.vertices[i], Vec3(-p.x(), p.y(), p.z()));
  }
  EXPECT_EQ(a.springs.stiffness, b.springs.stiffness);
  EXPECT_NEAR(b.rest_volume, a.rest_volume, 1e-15);  // it faces outwards
  const std::string paint = "{ file = \"flesh.ply\", attribute = \"soft\", scale = [0, 900] }";
  EXPECT_EQ(with(paint, fixed).muscles[0].springs.stiffness,
            with(paint).muscles[0].springs.stiffness);
}

TEST_F(Maps, ThicknessIsKeptFreeNodeByNode) {
  const std::string contact = "[contact]\nthickness = { flesh = ";
  const Model listed = with("1000", contact + "{ list = [" + numbers(0.001, 0.003) + "] } }\n");
  EXPECT_EQ(listed.surfaces[0].thicknesses.size(), mesh_.vertices.size());
  const Model plain = with("1000", contact + "0.002 }\n");
  EXPECT_EQ(with("1000", contact + "{ list = [" + numbers(0.002, 0.002) + "] } }\n").hash,
            plain.hash);
  EXPECT_NE(listed.hash, plain.hash);
  EXPECT_EQ(listed.part_hashes.size(), plain.part_hashes.size() + 1);
}

TEST_F(Maps, MistakesAreToldWithTheirPlace) {
  EXPECT_HAS(error_of("{ list = [1, 2] }"), "stiffness: 2 values for a mesh of 98 vertices");
  EXPECT_HAS(error_of("{ attribute = \"sofd\" }"), "did you mean \"soft\"");
  EXPECT_HAS(error_of("{ attribute = \"sofd\" }"), "it has: ");
  EXPECT_HAS(error_of("{ attribute = \"soft\", scale = [0, 0] }"), "stiffness: 0 at vertex 0");
  EXPECT_HAS(error_of("{ profile = [[0, 100], [1, -1]] }"), "profile.1.1");
  EXPECT_HAS(error_of("{ places = [[0, 0, 0, 0.1, 1]] }"), "base");
  EXPECT_HAS(error_of("{ file = \"rig.urdf\" }"), "is not a value of stiffness");
  EXPECT_HAS(error_of("{ attribute = \"_THEW_HARD\", file = \"flesh.gltf\" }"), "_THEW_SOFT");
}

}  // namespace
}  // namespace thew::tests
