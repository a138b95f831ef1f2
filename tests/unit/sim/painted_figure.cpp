// SPDX-License-Identifier: Apache-2.0
//
// What is painted on a character's own skin, on the figure as an artist's program writes it: in
// parts, with seams, in centimetres under a turned armature.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

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

const fs::path kPainted = fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/painted.toml";
constexpr double kReach = 0.03;  // m, [skin] reach

ModelDef defined(const Settings& settings) { return define_model(read_scene(kPainted, settings)); }

// With one fat (m; negative: as modelled) and slide everywhere.
Model model_with(double fat, double slide) {
  Scene scene = read_scene(kPainted);
  scene.skin.fat = fat, scene.skin.fat_map = {};
  scene.skin.slide = slide, scene.skin.slide_map = {};
  return build_model(scene);
}

// In the pose in which everything is made, at rest, and in the last frame.
struct Painted {
  Model model;
  Points at_rest;                             // m, the skin
  Points layer, layer_bent;                   // m
  std::vector<Points> muscles, muscles_bent;  // m

  Painted(double fat, double slide) : model(model_with(fat, slide)) {
    Parallel one(1);
    State state = initial_state(model);
    settle(model, one, state);
    at_rest = state.skin.x;
    layer = state.layer.x;
    for (const MuscleState& muscle : state.muscles) muscles.push_back(muscle.x);
    StageSeconds seconds;
    for (int f = 1; f <= 15; ++f) step_frame(model, f / model.fps, one, state, seconds);
    layer_bent = state.layer.x;
    for (const MuscleState& muscle : state.muscles) muscles_bent.push_back(muscle.x);
  }
};

// m, from the nearest muscle; negative inside.
double distance(const Model& model, const std::vector<Points>& muscles, const Point& p) {
  double least = 1.0;
  for (size_t m = 0; m < muscles.size(); ++m) {
    const Surface& surface = model.surfaces[m].surface;
    const Bvh bvh = build_bvh(surface, muscles[m]);
    least = std::min(least, closest_point(surface, bvh, muscles[m], to_vec(p), 1.0).distance);
  }
  return least;
}

// Share of the weights of a vertex on one of these bodies.
double share_on(const Character& character, size_t vertex, const std::vector<const char*>& names) {
  double sum = 0.0;
  const SkinWeights& skin = character.skin;
  for (int k = skin.first[vertex]; k < skin.first[vertex + 1]; ++k) {
    const std::string& body = character.skeleton.body_names[skin.links[skin.link[k]].body];
    if (std::find(names.begin(), names.end(), body) != names.end()) sum += skin.weight[k];
  }
  return sum;
}

// The vertices of the arm with muscle below them: as modelled no farther from one than `within`
// (m).
std::vector<int> over_muscle(const Painted& plain, double within) {
  std::vector<int> found;
  const Character& character = plain.model.character->character;
  for (size_t i = 0; i < plain.at_rest.size(); ++i) {
    if (plain.model.skinned->map_back[i] != static_cast<int>(i)) continue;
    if (share_on(character, i, {"LeftArm", "LeftForeArm"}) < 0.5) continue;
    if (distance(plain.model, plain.muscles, plain.at_rest[i]) < within) {
      found.push_back(static_cast<int>(i));
    }
  }
  return found;
}

TEST(PaintedFigure, ItsAttributeIsReadPartByPart) {
  const ModelDef def = defined({});
  const Character& character = def.character->character;
  ASSERT_EQ(def.skin.maps.fat.size(), character.mesh.vertices.size());
  int painted = 0;
  for (size_t p = 0; p < character.parts.size(); ++p) {
    const MeshPart& part = character.parts[p];
    const size_t end = p + 1 < character.parts.size() ? character.parts[p + 1].first_vertex
                                                      : character.mesh.vertices.size();
    for (size_t i = part.first_vertex; i < end; ++i) {
      if (part.mesh == "arms") {
        EXPECT_NEAR(def.skin.maps.fat[i],
                    0.005 + 0.004 * share_on(character, i, {"LeftArm", "RightArm"}), 1e-9);
        ++painted;
      } else {
        EXPECT_EQ(def.skin.maps.fat[i], -1.0) << part.mesh;  // as modelled
      }
    }
  }
  EXPECT_GT(painted, 900);
}

TEST(PaintedFigure, EachWayToGiveAMapGivesTheSame) {
  const ModelDef def = defined({});
  const TriMesh& mesh = def.character->character.mesh;
  std::vector<double> expected = def.skin.maps.fat;
  for (double& value : expected) value = std::max(value, 0.004);  // lists say something everywhere
  std::string list, places;
  for (size_t i = 0; i < expected.size(); ++i) {
    list += (i ? "," : "") + number_text(expected[i]);
    char line[128];
    const Vec3& p = mesh.vertices[i];
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g %.17g\n", p.x(), p.y(), p.z(), expected[i]);
    places += line;
  }
  const ModelDef listed = defined({"skin.fat={ list = [" + list + "] }"});
  // Vertices at one place have one value there.
  const fs::path folder = fs::path(testing::TempDir()) / ("painted_" + std::to_string(getpid()));
  fs::copy(kPainted.parent_path(), folder, fs::copy_options::recursive);
  std::ofstream(folder / "fat.txt") << places;
  const ModelDef placed =
      define_model(read_scene(folder / "painted.toml", {"skin.fat={ file = \"fat.txt\" }"}));
  fs::remove_all(folder);
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(listed.skin.maps.fat[i], expected[i], 1e-7);
    EXPECT_NEAR(placed.skin.maps.fat[i], expected[i], 1e-12);
  }
  const ModelDef balls =
      defined({"skin.fat={ places = [[0.27, 1.3, 0, 0.05, 0.01]], base = 0.004 }"});
  const auto [least, most] =
      std::minmax_element(balls.skin.maps.fat.begin(), balls.skin.maps.fat.end());
  EXPECT_EQ(*least, 0.004);
  EXPECT_GT(*most, 0.005);
}

// The left arm's positions in its file, in cm, as its colours.
TEST(PaintedFigure, ItsColoursAreReadPartByPart) {
  const fs::path folder = fs::path(testing::TempDir()) / ("coloured_" + std::to_string(getpid()));
  fs::copy(kPainted.parent_path(), folder, fs::copy_options::recursive);
  nlohmann::json gltf = nlohmann::json::parse(std::ifstream(folder / "dressed.gltf"));
  for (nlohmann::json& mesh : gltf["meshes"]) {
    if (mesh["name"] != "arms") continue;
    nlohmann::json& attributes = mesh["primitives"][0]["attributes"];
    attributes["COLOR_0"] = attributes["POSITION"];
  }
  std::ofstream(folder / "dressed.gltf") << gltf.dump();
  const ModelDef def = define_model(read_scene(
      folder / "painted.toml", {"skin.fat={ colour = \"green\", scale = [0.01, 0.0101] }"}));
  fs::remove_all(folder);
  const Character& character = def.character->character;
  int painted = 0;
  for (size_t p = 0; p + 1 < character.parts.size(); ++p) {
    const MeshPart& part = character.parts[p];
    const bool coloured = part.mesh == "arms" && part.primitive == 0;
    for (int i = part.first_vertex; i < character.parts[p + 1].first_vertex; ++i) {
      const Vec3 in_file = part.to_bind.inverse() * character.mesh.vertices[i];
      EXPECT_NEAR(def.skin.maps.fat[i], coloured ? 0.01 + 1e-4 * in_file.y() : -1.0, 1e-8);
      painted += coloured;
    }
  }
  EXPECT_GT(painted, 450);
}

TEST(PaintedFigure, MistakesAreToldWithTheirPlace) {
  const auto error = [](const std::string& setting) -> std::string {
    try {
      defined({setting});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_HAS(error("skin.fat={ attribute = \"_THEW_FAD\" }"), "did you mean \"_THEW_FAT\"");
  EXPECT_HAS(error("skin.fat={ list = [0.001, 0.002] }"), "2 values for a mesh of");
  EXPECT_HAS(error("skin.fat={ colour = \"red\" }"), "has no vertex colours");
  EXPECT_HAS(error("skin.fat={ attribute = \"_THEW_FAT\", scale = [0, 1] }"), "; give 0 to 0.03");
}

// 2 and 8 mm, where muscle lies below: there the layer is 6 mm apart. The triangles of this coarse
// skin, up to 30 mm wide, cut through a muscle 16 mm thick whose skin is at 2 mm, and so are moved
// out.
TEST(PaintedFigure, ItsSkinStandsOffByItsFat) {
  const Painted plain(-1.0, 1.0), thin(0.002, 1.0), thick(0.008, 1.0);
  constexpr double kSame = 1e-4;  // m
  int count = 0;
  for (const int i : over_muscle(plain, 0.015)) {
    const auto& nodes = plain.model.skinned->nodes;
    const auto found = std::find_if(nodes.begin(), nodes.end(), [&](const SkinnedSkin::Node& node) {
      return node.is_vertex() && node.corners[0] == i;
    });
    ASSERT_NE(found, nodes.end());
    const size_t n = found - nodes.begin();
    EXPECT_NEAR(distance(thin.model, thin.muscles, thin.layer[n]), 0.002, kSame) << i;
    EXPECT_NEAR(distance(thick.model, thick.muscles, thick.layer[n]), 0.008, kSame) << i;
    EXPECT_NEAR(norm(thick.layer[n] - thin.layer[n]), 0.006, 2 * kSame) << i;
    EXPECT_NEAR(distance(thick.model, thick.muscles, thick.at_rest[i]), 0.008, kSame) << i;
    EXPECT_GT(distance(thin.model, thin.muscles, thin.at_rest[i]), 0.002 - kSame) << i;
    EXPECT_LT(distance(thin.model, thin.muscles, thin.at_rest[i]), 0.005) << i;
    ++count;
  }
  EXPECT_GT(count, 30);
  // Nothing moves where the weights alone say where the skin is.
  int far = 0;
  for (size_t i = 0; i < plain.at_rest.size(); ++i) {
    if (distance(plain.model, plain.muscles, plain.at_rest[i]) < 3.0 * kReach) continue;
    EXPECT_EQ(norm(plain.at_rest[i] - thick.at_rest[i]), 0.0);
    ++far;
  }
  EXPECT_GT(far, 100);
}

// Where the arm bends muscles slide along below its skin. Skin that sticks goes with them: its
// layer, for coarse triangles are then moved out over what they cut off.
TEST(PaintedFigure, ItsSkinSticksOrSlides) {
  const Painted sticks(-1.0, 0.0), slides(-1.0, 1.0);
  ASSERT_TRUE(slides.model.skinned->layer.sites.empty());
  const SkinnedSkin& skin = *sticks.model.skinned;
  const auto off = [&](const Painted& run, size_t n) {  // from where the flesh takes it
    const SkinSite& site = skin.layer.sites[n];
    const Points& x = run.muscles_bent[site.collider];
    const Triangle& t = run.model.surfaces[site.collider].surface.triangles[site.triangle];
    Vec3 place = Vec3::Zero();
    for (int k = 0; k < 3; ++k) place += site.barycentric[k] * to_vec(x[t[k]]);
    return std::abs((to_vec(run.layer_bent[n]) - place).norm() - site.offset.norm());
  };
  double stuck = 0.0, free = 0.0;
  int count = 0;
  for (size_t n = 0; n < skin.nodes.size(); ++n) {
    if (!skin.nodes[n].is_vertex() || skin.nodes[n].is_held) continue;
    if (skin.layer.sites[n].offset.norm() > 0.015) continue;
    stuck += off(sticks, n), free += off(slides, n);
    ++count;
  }
  ASSERT_GT(count, 20);
  std::printf("%d vertices: %.2f mm off their flesh where they stick, %.2f where they slide\n",
              count, 1e3 * stuck / count, 1e3 * free / count);
  EXPECT_LT(stuck / count, 0.2e-3);
  EXPECT_GT(free / count, 2e-3);
}

// What is not set changes nothing, and what is set is in the hash, or a bake would be resumed.
TEST(PaintedFigure, NothingSetIsNothing) {
  const Model plain = model_with(-1.0, 1.0);
  EXPECT_TRUE(plain.skinned->lift.empty());
  EXPECT_TRUE(plain.skinned->layer.sites.empty());
  const std::string fat = model_with(0.004, 1.0).hash, slide = model_with(-1.0, 0.5).hash;
  EXPECT_NE(fat, plain.hash);
  EXPECT_NE(slide, plain.hash);
  EXPECT_NE(fat, slide);
}

}  // namespace
}  // namespace thew::tests
