// SPDX-License-Identifier: Apache-2.0
//
// Characters whose files are as people have them: more skeletons than needed, wrong weights.
#include "rig/import/character_import.h"
#include "tests/unit/tools/fit/new_figure.h"
#include "tools/fit/limb.h"

namespace thew::tests {
namespace {

class NewFiles : public NewScene {};

constexpr std::uint8_t kUpperArm = 3, kForearm = 4;  // joints of the left arm

// The figure in a shirt, by that much wider than the body, which may have a copy of the skeleton.
Figure in_a_shirt(bool own_skeleton, double wide = 1.08) {
  Figure figure;
  Figure::Mesh shirt = figure.meshes[0];
  shirt.name = "Shirt";
  Figure::thin(wide, shirt);
  shirt.cut([](const Vec3& p) { return std::abs(p.x()) < 0.1 || std::abs(p.x()) > 0.45; });
  if (own_skeleton) {
    const size_t count = figure.joints.size();
    for (size_t i = 0; i < count; ++i) {
      Figure::Joint joint = figure.joints[i];
      if (joint.parent >= 0) joint.parent += static_cast<int>(count);
      figure.joints.push_back(joint);
    }
    for (auto& joints : shirt.joints) {
      for (std::uint8_t& joint : joints) joint = static_cast<std::uint8_t>(joint + count);
    }
  }
  figure.meshes.push_back(shirt);
  return figure;
}

// Baked, the arm bent: the same skin as with one skeleton, shirt and all.
TEST_F(NewFiles, AShirtWithTheBodysSkeletonOnceMoreIsWornAsWithOne) {
  Points with_one;
  for (const bool own_skeleton : {false, true}) {
    const fs::path file = folder / (own_skeleton ? "two.gltf" : "one.gltf");
    in_a_shirt(own_skeleton).write(file);
    MadeArm arm(asked(file, "left"));
    for (const int frame : {12, 24, 36}) arm.step(frame);
    if (!own_skeleton) {
      with_one = arm.state.skin.x;
      continue;
    }
    ASSERT_EQ(arm.state.skin.x.size(), with_one.size());
    EXPECT_LT(largest_distance(arm.state.skin.x, with_one), 1e-9);
    const std::vector<Affine>& bind = arm.model.character->character.bind;
    EXPECT_EQ(arm.model.character->character.twins.size(), Figure().joints.size());
    double moved = 0.0;
    for (const Character::Twin& twin : arm.model.character->character.twins) {
      const int of = arm.model.character->character.skeleton.parent[twin.body];
      const Affine one = arm.state.bodies[of] * bind[of].inverse(),
                   other = arm.state.bodies[twin.body] * bind[twin.body].inverse();
      EXPECT_LT((one.matrix() - other.matrix()).norm(), 1e-9);
      moved = std::max(moved, (one.matrix() - Affine::Identity().matrix()).norm());
    }
    EXPECT_GT(moved, 0.5);
  }
}

// One vertex of `per` hangs on the hips by mistake.
Figure with_stray_weights(unsigned seed, unsigned per) {
  Figure figure;
  Figure::Mesh& body = figure.meshes[0];
  for (size_t i = 0; i < body.positions.size(); ++i) {
    seed = seed * 1664525u + 1013904223u;
    if ((seed >> 8) % per != 0) continue;
    body.joints[i] = {0, 0, 0, 0};
    body.weights[i] = {1.0f, 0.0f, 0.0f, 0.0f};
  }
  return figure;
}

// In the pose in which an arm is measured its skin has spikes, which lead through the arm; they are
// no thin places. These two had muscles too thin to bake, and of two thirds.
TEST_F(NewFiles, StrayWeightsAreNoThinPlaces) {
  const auto made = [&](const Figure& figure) {
    const fs::path file = folder / "figure.gltf";
    figure.write(file);
    EXPECT_EQ(new_command(asked(file, "both")), ExitCode::kDone);
    return build_model(read_scene(folder / "character.toml", {"skin.enabled=false"}));
  };
  const Model sound = made(Figure());
  for (const auto& [seed, per] : {std::pair(14299u, 50u), {12345u, 30u}}) {
    const Model stray = made(with_stray_weights(seed, per));
    ASSERT_EQ(stray.muscles.size(), sound.muscles.size());
    for (size_t m = 0; m < stray.muscles.size(); ++m) {
      EXPECT_GT(stray.muscles[m].rest_volume, 0.85 * sound.muscles[m].rest_volume)
          << stray.muscles[m].name;
    }
  }
}

// Each triangle once more, the other way round, to be seen from both sides: no inside was found.
TEST_F(NewFiles, AMeshThatIsDoubledIsAsOneThatIsNot) {
  std::vector<double> volumes;
  std::vector<size_t> nodes;
  for (const bool doubled : {false, true}) {
    Figure figure;
    std::vector<Triangle>& triangles = figure.meshes[0].triangles;
    const size_t count = doubled ? triangles.size() : 0;
    for (size_t i = 0; i < count; ++i) {
      const Triangle t = triangles[i];
      triangles.push_back({t[0], t[2], t[1]});
    }
    const fs::path file = folder / "figure.gltf";
    figure.write(file);
    MadeArm arm(asked(file, "left"));
    nodes.push_back(arm.model.skinned->nodes.size());
    for (const Muscle& muscle : arm.model.muscles) volumes.push_back(muscle.rest_volume);
    EXPECT_EQ(arm.model.skinned->mesh.triangles.size(), triangles.size()) << "as in the file";
  }
  EXPECT_EQ(nodes[0], nodes[1]);
  for (size_t m = 0; m < volumes.size() / 2; ++m) {
    EXPECT_EQ(volumes[m], volumes[m + volumes.size() / 2]);
  }
}

// On one joint, about a place, with half its edges (m).
Figure::Mesh box(const std::string& name, const Vec3& at, const Vec3& half, std::uint8_t joint) {
  Figure::Mesh box;
  box.name = name;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                      (i & 4) != 0 ? 1.0 : -1.0);
    box.positions.push_back(at + half.cwiseProduct(corner));
    box.joints.push_back({joint, 0, 0, 0});
    box.weights.push_back({1.0f, 0.0f, 0.0f, 0.0f});
  }
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1},
                                   {4, 5, 7, 6},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}}) {
    box.triangles.push_back({a, b, c});
    box.triangles.push_back({a, c, d});
  }
  return box;
}

double sum_of_volumes(const Model& model) {
  double sum = 0.0;
  for (const Muscle& muscle : model.muscles) sum += muscle.rest_volume;
  return sum;
}

// What an arm carries goes through its skin; it does not make it hard, as a robot's pieces are that
// go through each other. The muscles came out of such a skin by 15 mm.
TEST_F(NewFiles, AnArmThatCarriesAShieldKeepsItsSkin) {
  std::vector<size_t> nodes;
  std::vector<double> volumes;
  for (const bool carries : {false, true}) {
    Figure figure;
    if (carries)
      figure.meshes.push_back(box("Shield", Vec3(0.45, 1.14, 0.0), Vec3(0.1, 0.1, 0.01), kForearm));
    const fs::path file = folder / "figure.gltf";
    figure.write(file);
    MadeArm arm(asked(file, "left"));
    nodes.push_back(arm.model.skinned->nodes.size());
    volumes.push_back(sum_of_volumes(arm.model));
  }
  EXPECT_GT(static_cast<double>(nodes[1]), 0.98 * static_cast<double>(nodes[0]));
  EXPECT_GT(nodes[0], 100u);
  EXPECT_NEAR(volumes[1] / volumes[0], 1.0, 0.01);
}

// A pad around a place (m), of the left arm, wide along z: around the arm, or on the shoulder.
Figure::Mesh pad(const Vec3& at, std::uint8_t joint) {
  Figure::Mesh ball = box("Pad", at, Vec3(0.09, 0.09, 0.11), joint);
  for (Vec3& p : ball.positions) p = at + Eigen::AngleAxisd(0.7, Vec3::UnitZ()) * (p - at);
  return ball;
}

// Worn on the shoulder or around the forearm, and hard; or a padded jacket. Muscles filled them.
TEST_F(NewFiles, WhatIsWornOverAnArmTellsNothingOfItsGirth) {
  std::vector<double> volumes;
  for (const int worn : {0, 1, 2, 3}) {
    Figure figure = worn == 3 ? in_a_shirt(false, 2.0) : Figure();
    if (worn == 3) figure.meshes[1].cut([](const Vec3& p) { return std::abs(p.x()) < 0.21; });
    if (worn == 1) figure.meshes.push_back(pad(Vec3(0.25, 1.31, -0.02), kUpperArm));
    if (worn == 2) figure.meshes.push_back(pad(Vec3(0.45, 1.14, 0.0), kForearm));
    const fs::path file = folder / "figure.gltf";
    figure.write(file);
    EXPECT_EQ(new_command(asked(file, "left")), ExitCode::kDone);
    volumes.push_back(
        sum_of_volumes(build_model(read_scene(folder / "character.toml", {"skin.enabled=false"}))));
    EXPECT_NEAR(volumes.back() / volumes[0], 1.0, 0.03) << worn;
  }
}

// Of one mesh in several levels of detail the finest alone is skin.
TEST_F(NewFiles, CoarserLevelsOfDetailAreLeftOut) {
  Figure figure;
  const Figure::Mesh body = figure.meshes[0];
  figure.meshes.clear();
  for (const char* name : {"LOD2_Body", "lod0_Body", "Melody2"}) {
    Figure::Mesh& mesh = figure.meshes.emplace_back(body);
    mesh.name = name;
    if (mesh.name != "lod0_Body") Figure::thin(0.9, mesh);
  }
  const fs::path file = folder / "figure.gltf";
  figure.write(file);
  const Character character = rig::import_character(file);
  EXPECT_EQ(tools::mesh_names(character), (std::vector<std::string>{"Melody2", "lod0_Body"}));
  ASSERT_EQ(character.mesh.vertices.size(), 2 * body.positions.size());
  EXPECT_EQ(character.mesh.triangles.size(), 2 * body.triangles.size());
  double farthest = 0.0;
  for (size_t i = 0; i < body.positions.size(); ++i) {
    const Vec3 d = character.mesh.vertices[i] - body.positions[i];
    farthest = std::max(farthest, d.norm());
  }
  EXPECT_LT(farthest, 1e-6);
  ASSERT_EQ(character.warnings.size(), 1u);
  EXPECT_NE(character.warnings[0].find("LOD2_Body"), std::string::npos) << character.warnings[0];
}

}  // namespace
}  // namespace thew::tests
