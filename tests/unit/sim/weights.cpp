// SPDX-License-Identifier: Apache-2.0
//
// Weights of a muscle's nodes, however they are given.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/distance.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class PlacedWeights : public TempFolder {
 protected:
  Model with(const std::string& weights) {
    fs::copy_file(fs::path(THEW_SOURCE_DIR) / "tests/scenes/one_muscle/rig.urdf",
                  folder / "rig.urdf", fs::copy_options::overwrite_existing);
    return build_model(
        read_scene(write("scene.toml",
                         "[rig]\nfile = \"rig.urdf\"\n[[muscle]]\nname = \"a\"\npath = "
                         "[[\"humerus\", 0.03, -0.03, 0], [\"ulna\", 0.03, -0.05, 0]]\nprofile = "
                         "{ around = 8, rings = 9, radius = [[0, 0.01]] }\nweights = " +
                             weights + "\n")));
  }
};

TEST_F(PlacedWeights, FindTheirVerticesInAnyOrder) {
  const Model even = with("\"even\"");
  const std::vector<Vec3>& rest = even.muscles[0].rest.vertices;
  std::string list;
  for (size_t i = rest.size(); i-- > 0;) {
    char line[128];
    std::snprintf(line, sizeof line, "%.9f %.9f %.9f %d\n", rest[i].x() + 2e-4, rest[i].y(),
                  rest[i].z(), i % 8 == 1 ? 3 : 1);
    list += line;
  }
  write("w.txt", list);
  const Model placed = with("{ file = \"w.txt\" }");
  const std::vector<double>&a = even.muscles[0].weights, &b = placed.muscles[0].weights;
  double heavy = 0.0, light = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] > 0.0) (i % 8 == 1 ? heavy : light) = b[i] / a[i];
  }
  EXPECT_NEAR(heavy / light, 3.0, 1e-9);
  try {
    with("{ file = \"w.txt\", tolerance = 1e-4 }");
    ADD_FAILURE() << "0.2 mm are within 0.1 mm";
  } catch (const Error& error) {
    EXPECT_HAS(std::string(error.what()), "tolerance");
  }
}

TEST_F(PlacedWeights, ColoursOfAPaintedMesh) {
  const Model even = with("\"even\"");
  const TriMesh& rest = even.muscles[0].rest;
  std::string ply = "ply\nformat ascii 1.0\nelement vertex " +
                    std::to_string(rest.vertices.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
                    "red\nproperty uchar green\nproperty uchar blue\nelement face " +
                    std::to_string(rest.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (size_t i = 0; i < rest.vertices.size(); ++i) {
    char line[128];
    std::snprintf(line, sizeof line, "%.9f %.9f %.9f 51 %d 0\n", rest.vertices[i].x(),
                  rest.vertices[i].y(), rest.vertices[i].z(), i % 8 == 1 ? 255 : 85);
    ply += line;
  }
  for (const Triangle& t : rest.triangles) {
    ply += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
           "\n";
  }
  write("painted.ply", ply);
  const Model painted = with("{ colour = \"green\", file = \"painted.ply\" }");
  const std::vector<double>&a = even.muscles[0].weights, &b = painted.muscles[0].weights;
  double heavy = 0.0, light = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] > 0.0) (i % 8 == 1 ? heavy : light) = b[i] / a[i];
  }
  EXPECT_NEAR(heavy / light, 3.0, 1e-6);
}

// One weight for each ring of nodes, all of them sums of powers of two, which any way to write them
// holds exactly.
class OneVector : public TempFolder {
 protected:
  void SetUp() override {
    TempFolder::SetUp();
    const fs::path scene = fs::path(THEW_SOURCE_DIR) / "tests/scenes/one_muscle";
    for (const char* name : {"rig.urdf", "scene.toml"}) fs::copy_file(scene / name, folder / name);
    const Model even = with("\"even\"", "target");
    const Muscle& muscle = even.muscles[0];
    rest_ = muscle.rest;
    for (size_t i = 0; i < rest_.vertices.size(); ++i) {
      const double u = belly_coordinate(muscle.shape, static_cast<int>(i));
      const double ring = std::round(20.0 * u);
      const double weight = 0.25 + 0.125 * std::fmod(7.0 * ring, 11.0);
      weights_.push_back(weight);
      profile_[u] = weight;
    }
  }
  Model with(const std::string& weights, const std::string& shape) {
    return build_model(read_scene(folder / "scene.toml", {"muscle.flexor.shape=" + shape,
                                                          "muscle.flexor.weights=" + weights}));
  }
  State last(const Model& model) {
    Parallel parallel(1);
    State state = initial_state(model);
    settle(model, parallel, state);
    StageSeconds seconds;
    for (int f = 1; f < 12; ++f) step_frame(model, f / 24.0, parallel, state, seconds);
    return state;
  }
  std::string profile() const {
    std::string text;
    for (const auto& [u, weight] : profile_) {
      char pair[64];
      std::snprintf(pair, sizeof pair, "%s[%.17g, %.17g]", text.empty() ? "" : ", ", u, weight);
      text += pair;
    }
    return "{ profile = [" + text + "] }";
  }
  std::string list(const std::vector<double>& values, bool with_places) {
    std::string text;
    for (size_t i = 0; i < values.size(); ++i) {
      char line[160];
      const Vec3& p = rest_.vertices[i];
      if (with_places) {
        std::snprintf(line, sizeof line, "%.17g %.17g %.17g %.17g\n", p.x(), p.y(), p.z(),
                      values[i]);
      } else {
        std::snprintf(line, sizeof line, "%.17g\n", values[i]);
      }
      text += line;
    }
    write("weights.txt", text);
    return "{ file = \"weights.txt\" }";
  }
  std::string colours() {
    std::string ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(weights_.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                      "red\nproperty float green\nproperty float blue\nelement face " +
                      std::to_string(rest_.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
    for (size_t i = 0; i < weights_.size(); ++i) {
      char line[160];
      const Vec3& p = rest_.vertices[i];
      std::snprintf(line, sizeof line, "%.9g %.9g %.9g 0 %.9g 0\n", p.x(), p.y(), p.z(),
                    weights_[i]);
      ply += line;
    }
    for (const Triangle& t : rest_.triangles) {
      ply += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
             "\n";
    }
    write("painted.ply", ply);
    return "{ colour = \"green\", file = \"painted.ply\" }";
  }

  TriMesh rest_;
  std::vector<double> weights_;
  std::map<double, double> profile_;
};

TEST_F(OneVector, GivesOneResultHoweverItIsWritten) {
  for (const char* shape : {"target", "weights"}) {
    SCOPED_TRACE(shape);
    const Model model = with(profile(), shape);
    const State state = last(model);
    EXPECT_GT(worst_distance(state, last(with("\"even\"", shape))), 1e-4);  // it says something
    EXPECT_LT(worst_distance(state, last(with(list(weights_, false), shape))), 1e-9);
    EXPECT_LT(worst_distance(state, last(with(list(weights_, true), shape))), 1e-9);
    EXPECT_LT(worst_distance(state, last(with(colours(), shape))), 1e-9);
    // A bake's own weights, given back.
    const BakeInfo baked = bake_info(model, {1});
    EXPECT_LT(worst_distance(state, last(with(list(baked.meshes[0].weights, false), shape))), 1e-9);
  }
}

// On a few nodes they get a floor, which is in what the multiplier goes by and not in what is
// baked.
TEST_F(OneVector, WhatIsLimitedAlreadyIsLeftAlone) {
  std::vector<double> few(weights_.size(), 0.0);
  for (size_t i = few.size() / 2; i < few.size() / 2 + 3; ++i) few[i] = 1.0;
  const Model once = with(list(few, false), "target");
  EXPECT_GT(once.muscles[0].weight_floor, 0.0);
  const State state = last(once);
  const BakeInfo baked = bake_info(once, {1});
  const Model again = with(list(baked.meshes[0].weights, false), "target");
  EXPECT_LT(worst_distance(state, last(again)), 1e-9);
}

}  // namespace
}  // namespace thew::tests
