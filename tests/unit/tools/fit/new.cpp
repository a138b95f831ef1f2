// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/tools/fit/new.h"

#include <algorithm>

#include "rig/import/character_import.h"
#include "rig/import/gltf_file.h"
#include "rig/text.h"
#include "sim/bake/measure.h"
#include "sim/framing.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/property/every.h"
#include "tools/cli/inspect_command.h"
#include "tools/fit/arm.h"
#include "tools/render/camera.h"

namespace thew::tests {
namespace {

TEST_F(NewScene, BothArmsOfTheRobotAreBuiltMirrored) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  NewOptions options = asked(data("robot.glb"), "both", 0.4);
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const Scene scene = read_scene(options.out);
  const Model model = build_model(scene);  // all meshes closed, outward
  ASSERT_EQ(model.muscles.size(), 24u);
  EXPECT_EQ(model.bones.size(), 26u);  // of which each hand's four fingers have two
  for (size_t m = 0; m < 12; ++m) {
    EXPECT_EQ(
        model.muscles[m].name,
        scene.muscles[m + 12].name.substr(0, scene.muscles[m + 12].name.rfind("_left")) + "_right");
    EXPECT_GT(model.muscles[m].rest_volume, 0.0);
    EXPECT_GT(model.muscles[m + 12].rest_volume, 0.0);
  }
  options.force = false;
  EXPECT_THROW(new_command(options), Error);  // what is there may have been edited
}

// The straight arm's path is the same; bent, it stays as near to the elbow as in an arm that is the
// template's in the small.
// Its bytes lay in another file, which stayed behind: the scene could not be read.
TEST_F(NewScene, WhatAGltfKeepsInFilesOfItsOwnComesAlong) {
  auto figure = nlohmann::json::parse(read_whole(kFigure, size_t{1} << 30));
  nlohmann::json& uri = figure["buffers"][0]["uri"];
  const auto bytes = rig::GltfFile::bytes_of_uri(uri);
  ASSERT_TRUE(bytes);
  fs::create_directories(folder / "from" / "parts");
  write("from/parts/all of it.bin", *bytes);
  uri = "parts/all%20of%20it.bin";
  // What is not read is not there to be copied, and nothing above the folder is.
  write("above.png", "");
  figure["images"] = {{{"uri", "missing.png"}},
                      {{"uri", "../above.png"}},
                      {{"uri", std::string(5000, 'a')}},
                      {{"uri", "%00"}},
                      {{"uri", "."}}};
  write("from/figure.gltf", figure.dump());
  NewOptions options = asked(folder / "from" / "figure.gltf", "right");
  options.out = folder / "scene" / "character.toml";
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  fs::remove_all(folder / "from");
  EXPECT_EQ(read_whole(folder / "scene" / "parts" / "all of it.bin", size_t{1} << 30), *bytes);
  EXPECT_FALSE(fs::exists(folder / "scene" / "above.png"));
  EXPECT_EQ(build_model(read_scene(options.out, {"skin.enabled=false"})).muscles.size(), 12u);
}

TEST(HoldAtElbow, GoesByTheGirthOfASlenderArm) {
  ArmFit fit;
  fit.elbow_template = Vec3(0.0, -0.3, 0.0);
  fit.girth.even = 0.4;
  const ArmBodies arm{.humerus = 0, .forearm = 1, .hand = 2, .ulna = 1, .radius = 1};
  Pose rest(3, Transform::Identity());
  for (int b = 1; b < 3; ++b) rest[b].translation().y() = -0.3 * b;
  const MusclePath plain{
      {{0, Vec3(0.02, -0.1, 0.0)}, {0, Vec3(0.02, -0.2, 0.0)}, {1, Vec3(0.02, -0.05, 0.0)}},
      {{1, 0, Vec3(0.0, -0.3, 0.0), Vec3::UnitZ(), 0.01, -1.0}}};
  MusclePath held = plain, thick = plain;
  hold_at_elbow(fit, arm, rest, {-0.1, -0.2, -0.35}, held);
  ASSERT_EQ(held.points.size(), 5u);  // on either side as near to the joint as it is thick
  EXPECT_LT((rest[0] * held.points[2].position - Vec3(0.02, -0.26, 0.0)).norm(), 1e-12);
  EXPECT_LT((rest[1] * held.points[3].position - Vec3(0.02, -0.32, 0.0)).norm(), 1e-12);
  EXPECT_EQ(held.wraps[0].segment, 2);  // goes with the piece across the joint
  EXPECT_NEAR(trace_path(held, rest).length, trace_path(plain, rest).length, 1e-12);
  fit.girth.even = 0.9;
  hold_at_elbow(fit, arm, rest, {-0.1, -0.2, -0.35}, thick);
  EXPECT_EQ(thick.points.size(), 3u);
}

// m, of a path to the joint at the origin, the least with the arm raised by up to `most` degrees in
// any plane.
double nearest_to_joint(const MusclePath& path, const Pose& rest, int most) {
  double least = 1.0;
  for (int plane = 0; plane < 12; ++plane) {
    const auto [s, c] = sin_cos(plane * kPi / 6.0);
    for (int degrees = 0; degrees <= most; degrees += 10) {
      const Mat3 turn = rotation_about(Vec3(c, 0.0, s), degrees * kDegree);
      Pose pose = rest;
      for (int b = 1; b < 4; ++b) pose[b] = Transform(turn) * rest[b];
      const std::vector<Vec3> points = trace_path(path, pose).points;
      for (size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 along = points[i + 1] - points[i];
        const double t = std::clamp(-along.dot(points[i]) / along.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (points[i] + t * along).norm());
      }
    }
  }
  return least;
}

// At rest the path is the same; what lies beside the upper arm goes with it, and before it a point
// half way keeps the path in front of the head.
TEST(HoldAtShoulder, TakesWhatIsBelowTheJointAlong) {
  const ArmBodies arm{
      .clavicle = 0, .humerus = 1, .forearm = 2, .hand = 3, .ulna = 2, .radius = 2, .scapula = 0};
  Pose rest(4, Transform::Identity());
  for (int b = 1; b < 4; ++b) rest[b].translation().y() = -0.3 * (b - 1);
  rest[1].linear() = rotation_about(Vec3::UnitX(), 0.4);
  const MusclePath plain{{{0, Vec3(0.03, -0.01, 0.0)},
                          {0, Vec3(0.03, 0.01, 0.0)},
                          {0, Vec3(0.02, -0.03, 0.0)},
                          {1, Vec3(0.01, -0.13, 0.0)}},
                         {}};
  MusclePath held = plain;
  hold_at_shoulder(arm, rest, held);
  ASSERT_EQ(held.points.size(), 5u);
  const auto at = [&](const PathPoint& point) { return Vec3(rest[point.body] * point.position); };
  EXPECT_LT((at(held.points[2]) - Vec3(0.025, -0.01, 0.0)).norm(), 1e-15);
  const double with = nearest_to_joint(held, rest, 90);
  held.points.erase(held.points.begin() + 2);
  for (size_t i = 0; i < plain.points.size(); ++i) {
    EXPECT_EQ(held.points[i].body, i < 2 ? 0 : 1) << i;
    EXPECT_LT((at(held.points[i]) - at(plain.points[i])).norm(), 1e-15) << i;
  }
  const double without = nearest_to_joint(held, rest, 90);
  EXPECT_GT(with, 0.02);
  EXPECT_LT(without, 0.01);
}

// From behind the joint to the shaft, as on slender and on wide shoulders: raised by 150 degrees in
// any plane, the path goes round the head. At rest it is the same.
class HeldAtShoulder : public testing::TestWithParam<Vec3> {};
TEST_P(HeldAtShoulder, GoesRoundTheHead) {
  const ArmBodies arm{
      .clavicle = 0, .humerus = 1, .forearm = 2, .hand = 3, .ulna = 2, .radius = 2, .scapula = 0};
  Pose rest(4, Transform::Identity());
  for (int b = 1; b < 4; ++b) rest[b].translation().y() = -0.3 * (b - 1);
  const MusclePath plain{
      {{0, GetParam()}, {1, Vec3(-0.02, -0.09, 0.0)}, {2, Vec3(-0.02, 0.01, 0.0)}},
      {{1, 1, Vec3(0.0, -0.3, 0.0), Vec3::UnitZ(), 0.01, 1.0}}};
  MusclePath held = plain;
  hold_at_shoulder(arm, rest, held);
  ASSERT_EQ(held.points.size(), 4u);
  EXPECT_EQ(held.wraps[0].segment, 2);
  EXPECT_NEAR(trace_path(held, rest).length, trace_path(plain, rest).length, 1e-12);
  const double origin = plain.points[0].position.norm();
  EXPECT_LT(nearest_to_joint(plain, rest, 150), 0.3 * origin);
  EXPECT_GT(nearest_to_joint(held, rest, 150), 0.5 * origin);
}
INSTANTIATE_TEST_SUITE_P(, HeldAtShoulder,
                         testing::Values(Vec3(-0.015, -0.015, 0.0), Vec3(-0.04, -0.03, 0.0)));

TEST_F(NewScene, ArmsAreFoundByShapeWhereNamesSayNothing) {
  if (!fs::exists(data("cesium_man.gltf"))) GTEST_SKIP() << "cesium_man.gltf is not there";
  const Character man = import_character(data("cesium_man.gltf"));
  std::vector<std::string> notes;
  const auto arms = find_arms(man, "both", {}, "man", notes);
  ASSERT_EQ(arms.size(), 2u);
  EXPECT_EQ(notes.size(), 2u);
  // He looks along +x, so his right is at +z.
  EXPECT_GT(man.bind[arms[0].humerus].translation().z(), 0.0);
  EXPECT_LT(man.bind[arms[1].humerus].translation().z(), 0.0);
  EXPECT_EQ(man.skeleton.parent[arms[0].hand], arms[0].forearm);
  EXPECT_EQ(man.skeleton.parent[arms[0].forearm], arms[0].humerus);
}

// As Blender's Collada has them.
TEST_F(NewScene, ArmsAreFoundByNamesBehindTheArmatures) {
  Character figure = import_character(kFigure);
  std::vector<std::string> notes;
  const auto plain = find_arms(figure, "both", {}, "figure", notes);
  for (std::string& name : figure.skeleton.body_names) name = "FigureArmature_" + name;
  const auto arms = find_arms(figure, "both", {}, "figure", notes);
  EXPECT_TRUE(notes.empty());
  for (int side = 0; side < 2; ++side) {
    EXPECT_EQ(arms[side].clavicle, plain[side].clavicle);
    EXPECT_EQ(arms[side].humerus, plain[side].humerus);
    EXPECT_EQ(arms[side].forearm, plain[side].forearm);
    EXPECT_EQ(arms[side].hand, plain[side].hand);
  }
}

// His humerus has a sliver turned over, in front of which nothing is inside.
TEST_F(NewScene, OverlapsAreToldOnlyWhereTheyAre) {
  if (!fs::exists(data("cesium_man.gltf"))) GTEST_SKIP() << "cesium_man.gltf is not there";
  const NewOptions options = asked(data("cesium_man.gltf"), "both");
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const Model model = build_model(read_scene(options.out));
  const State state = initial_state(model);
  const std::vector<std::string> told = rest_overlaps(model);
  const auto is_told = [&](const std::string& a, const std::string& b) {
    return std::any_of(told.begin(), told.end(), [&](const std::string& line) {
      return line.find("\"" + a + "\" and \"" + b + "\"") != std::string::npos;
    });
  };
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    for (size_t b = 0; b < model.bones.size(); ++b) {
      if (!is_told(model.muscles[m].name, model.bones[b].name)) continue;
      TriMesh bone{{}, model.bones[b].in_body.triangles};
      for (const Point& x : state.bones[b].x) bone.vertices.push_back(to_vec(x));
      double deepest = 0.0;
      for (const Point& x : state.muscles[m].x) {
        if (winding(bone, to_vec(x)) > 0.5) deepest = std::max(deepest, distance(bone, to_vec(x)));
      }
      EXPECT_GT(deepest, 0.9e-3) << model.muscles[m].name << ", " << model.bones[b].name;
    }
  }
}

TEST_F(NewScene, LandmarksLandOnTheCharactersJoints) {
  if (!fs::exists(data("cesium_man.gltf"))) GTEST_SKIP() << "cesium_man.gltf is not there";
  const Character man = import_character(data("cesium_man.gltf"));
  std::vector<std::string> notes;
  const ArmTemplate landmarks{Vec3(0.006, -0.29, -0.012),
                              Vec3(0.028, -0.56, 0.035),
                              Vec3(0.05, 0.04, 0.998).normalized(),
                              {},
                              {}};
  const auto arms = find_arms(man, "both", {}, "man", notes);
  std::vector<ArmFit> fits;
  for (const ArmBodies& arm : arms) fits.push_back(fit_arm(man, arm, landmarks));
  const Pose rest = straight_pose(man, arms, fits);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_LT((map_point(fits[i], Vec3::Zero()) - rest[arms[i].humerus].translation()).norm(),
              1e-6);
    EXPECT_LT((map_point(fits[i], landmarks.elbow) - rest[arms[i].forearm].translation()).norm(),
              1e-6);
    EXPECT_LT((map_point(fits[i], landmarks.wrist) - rest[arms[i].hand].translation()).norm(),
              1e-6);
    EXPECT_EQ(fits[i].frame.determinant() < 0.0, arms[i].left);
  }
  // The two arms of a man who is alike on both sides are mapped alike, mirrored in z.
  for (const Vec3& p : {Vec3(0.05, -0.1, 0.02), Vec3(0.03, -0.4, -0.01)}) {
    Vec3 a = map_point(fits[0], p), b = map_point(fits[1], p);
    b.z() = -b.z() - 0.01;  // his middle lies at -5 mm
    EXPECT_LT((a - b).norm(), 2e-3);
  }
}

// A figure whose arms are thinner than the template's, its bones beside the middle of the flesh.
TEST_F(NewScene, MusclesLieUnderTheSkinAtRest) {
  const NewOptions options = asked(kFigure, "both");
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const Model model = build_model(read_scene(options.out));
  ASSERT_EQ(model.muscles.size(), 24u);
  TriMesh skin = model.character->character.mesh;
  for (size_t i = 0; i < skin.vertices.size(); ++i) {
    skin.vertices[i] = to_vec(model.skinned->rest[i]);
  }
  int outside = 0, checked = 0;
  double least = 1.0, volume = 0.0;
  for (const Muscle& muscle : model.muscles) volume += muscle.rest_volume;
  for (const std::vector<Vec3>& x : TiedPose(model).muscles) {
    for (size_t i = 0; i < x.size(); ++i, ++checked) {
      if (winding(skin, x[i]) < 0.5) ++outside;
      if (i % 7 == 0) least = std::min(least, distance(skin, x[i]));
    }
  }
  std::printf("%d of %d vertices outside, %.2f mm or more under the skin, %.0f cm3\n", outside,
              checked, 1e3 * least, 1e6 * volume);
  EXPECT_EQ(outside, 0);
  EXPECT_GT(least, 0.7e-3);   // 2 mm, or a tenth of the way out, along rays from the axis
  EXPECT_GT(volume, 600e-6);  // of the template's 1710, in arms 0.8 of its length
  const std::string text = read_whole(options.out, 1 << 20);
  EXPECT_HAS(text, "mm or more under the skin");
  EXPECT_HAS(inspect(options.out, false).text, "the character's own");
}

// Of the skin that hangs on the upper arm, straight and flexed: how far from the picture's middle
// it is drawn, 1 being the picture's edge.
double farthest_in_view(const NewOptions& options) {
  EXPECT_EQ(new_command(options), ExitCode::kDone);
  double most = 0.0;
  std::string keys;
  for (const auto& hinge : read_scene(options.out).character.hinges) {
    keys += (keys.empty() ? "" : ", ") + hinge.name +
            (hinge.name.starts_with("elbow")
                 ? " = [[1, 0], [25, 60], [49, 120]]"
                 : " = [[1, " + number_text(hinge.at_bind / kDegree) + "]]");
  }
  const Scene scene =
      read_scene(options.out, {"rig.clip={ unit = \"deg\", keys = { " + keys + " } }"});
  const Model model = build_model(scene);
  const std::vector<SceneView> views = frame_views(model, scene.render);
  State state = initial_state(model);
  for (const double time : {0.0, 1.0, 2.0}) {  // s
    drive_bones(model, time, state);
    const SkinWeights& skin = model.skinned->weights;
    Points x;
    skin_vertices(skin, model.skinned->mesh, state.bodies, x);
    std::vector<int> humeri;
    for (const auto& hinge : scene.character.hinges) {
      if (hinge.name.starts_with("shoulder")) {
        humeri.push_back(find_body(model.skeleton, hinge.body));
      }
    }
    const SceneRender& render = scene.render;
    for (const SceneView& view : views) {
      const SceneView now = view_at(view, scene.first_frame + static_cast<int>(time * scene.fps));
      const Camera camera = make_camera(now, 1.0 * render.width / render.height, {});
      for (size_t i = 0; i < x.size(); ++i) {
        double share = 0.0;
        for (int k = skin.first[i]; k < skin.first[i + 1]; ++k) {
          const int body = skin.links[skin.link[k]].body;
          for (const int humerus : humeri) {
            if (hangs_on(model.skeleton, body, humerus)) share += skin.weight[k];
          }
        }
        if (share < 0.9) continue;
        const Vec3 seen = camera.view_from_world * to_vec(x[i]);
        most = std::max({most, std::abs(seen.x() / seen.z()) / camera.tan_x,
                         std::abs(seen.y() / seen.z()) / camera.tan_y});
      }
    }
  }
  std::printf("%.2f of the picture\n", most);
  return most;
}

// A hand longer than the template's was cut off.
TEST_F(NewScene, ViewsShowTheWholeArm) {
  const auto expect_seen = [&](const fs::path& file, const char* side, double scale) {
    const double far = farthest_in_view(asked(file, side, scale));
    EXPECT_LT(far, 0.95) << file << side;
    EXPECT_GT(far, 0.6) << file << side;
  };
  for (const auto& [file, scale] : characters()) {
    expect_seen(file, "both", scale);
    if (file == kFigure || every(2) == 1) expect_seen(file, "left", scale);
  }
}

TEST_F(NewScene, DoubtIsToldWithItsCandidates) {
  if (!fs::exists(data("robot.glb"))) GTEST_SKIP() << "robot.glb is not there";
  const Character robot = import_character(data("robot.glb"));
  std::vector<std::string> notes;
  const auto message = [&](const Character& character, const BoneMap& map) -> std::string {
    try {
      find_arms(character, "right", map, "x.glb", notes);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(robot, {}), "");
  EXPECT_HAS(message(robot, {{"humerus", "UpperArmR"}}), "did you mean \"UpperArm.R\"");
  EXPECT_HAS(message(robot, {{"humerous", "UpperArm.R"}}), "did you mean \"humerus\"");
  EXPECT_HAS(message(robot, {{"forearm", "Neck"}}), "does not hang on");
  // None is passed over in silence.
  const auto both = [&](const BoneMap& map, const std::string& side) -> std::string {
    try {
      find_arms(robot, side, map, "x.glb", notes);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_HAS(both({{"humerus", "UpperArm.R"}}, "both"), "on which side?");
  EXPECT_HAS(both({{"left_humerus", "UpperArm.L"}}, "right"), "not on the side asked for");
  EXPECT_EQ(both({{"left_humerus", "UpperArm.L"}, {"right_humerus", "UpperArm.R"}}, "both"), "");
  Character nameless;  // a trunk
  for (int i = 0; i < 4; ++i) {
    nameless.skeleton.body_names.push_back("b" + std::to_string(i));
    nameless.skeleton.parent.push_back(i - 1);
    nameless.bind.push_back(Affine(Eigen::Translation3d(0.0, 0.2 * i, 0.0)));
  }
  EXPECT_HAS(message(nameless, {}), "Candidates:");
}

}  // namespace
}  // namespace thew::tests
