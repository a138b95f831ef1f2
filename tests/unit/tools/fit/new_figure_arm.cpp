// SPDX-License-Identifier: Apache-2.0
//
// thew new on the project's figure, dressed, cut, scaled and maimed: a scene that can be used, or a
// refusal that says why. One process, whose tests compare with one figure as it is.
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "rig/import/urdf_import.h"
#include "rig/text.h"
#include "sim/framing.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tests/unit/tools/fit/new_figure.h"
#include "tools/render/camera.h"

namespace thew::tests {
namespace {

class NewFigure : public FigureScene {
 protected:
  // Without its skin, which takes as long as all else, and with it.
  Model made(const NewOptions& asked_for) { return built(asked_for, {"skin.enabled=false"}); }
  Model made_with_skin(const NewOptions& asked_for) { return built(asked_for, {}); }
  // The figure as it is, made by the first test that asks.
  const Model& plain() {
    static const Model model = made(options(Figure()));
    return model;
  }
  // The refusal, with a picture that it names and no scene.
  std::string refusal(const NewOptions& asked_for) {
    try {
      new_command(asked_for);
    } catch (const Error& error) {
      EXPECT_FALSE(fs::exists(asked_for.out));
      return error.what();
    }
    ADD_FAILURE() << "taken";
    return "";
  }
  fs::path why() { return folder / "scene" / "character.why.svg"; }
};

double volume_of(const Model& model) {
  double sum = 0.0;
  for (const Muscle& muscle : model.muscles) sum += muscle.rest_volume;
  return sum;
}

// Muscle vertices outside of a closed surface.
int outside(const Model& model, const TriMesh& shell) {
  int count = 0;
  for (const std::vector<Vec3>& x : TiedPose(model).muscles) {
    for (size_t i = 0; i < x.size(); i += 5) count += winding(shell, x[i]) < 0.5;
  }
  return count;
}

// The first mesh that the scene's character has, at rest.
TriMesh shell_of(const Model& model, size_t mesh) {
  const Character& character = model.character->character;
  const int first = character.parts[mesh].first_vertex;
  const int end = mesh + 1 < character.parts.size()
                      ? character.parts[mesh + 1].first_vertex
                      : static_cast<int>(character.mesh.vertices.size());
  TriMesh shell;
  for (const Point& x : model.skinned->rest) shell.vertices.push_back(to_vec(x));
  for (const Triangle& t : character.mesh.triangles) {
    if (t[0] >= first && t[0] < end) shell.triangles.push_back(t);
  }
  return shell;
}

// A body within its clothes, thinner, with nothing below them in places: muscles as in the clothes.
TEST_F(NewFigure, LayersAreFilledToTheOutermost) {
  const double whole = volume_of(plain());
  Figure figure;
  Figure::Mesh body = figure.meshes[0];
  figure.meshes[0].name = "Shirt";
  Figure::thin(0.4, body);
  // Cut away under the left sleeve, the right arm is whole.
  body.cut([](const Vec3& p) { return p.x() > 0.2 && p.x() < 0.33; });
  figure.meshes.insert(figure.meshes.begin(), body);
  const Model model = made_with_skin(options(figure));
  EXPECT_NEAR(volume_of(model) / whole, 1.0, 0.02);
  EXPECT_EQ(outside(model, shell_of(model, 1)), 0);
  // Who wants the body under the clothes says so.
  NewOptions bare = options(figure, "right");
  bare.skin = {"Body"};
  EXPECT_LT(volume_of(made(bare)) / whole, 0.25);
  bare.skin = {"Boddy"};
  bare.out = folder / "none.toml";
  EXPECT_HAS(refusal(bare), "did you mean \"Body\"");
}

// Holes all over, each with the wall of an inner tube behind it.
TEST_F(NewFigure, HolesAndInnerWallsTakeNoRoom) {
  const double whole = volume_of(plain());
  Figure figure;
  Figure::Mesh inner = figure.meshes[0];
  inner.name = "Inner";
  Figure::thin(0.3, inner);
  std::vector<Triangle>& triangles = figure.meshes[0].triangles;
  for (size_t i = triangles.size(); i-- > 0;) {
    if (i % 7 == 0) triangles.erase(triangles.begin() + static_cast<std::ptrdiff_t>(i));
  }
  const double alone = volume_of(made(options(figure)));
  figure.meshes.push_back(inner);
  const double walled = volume_of(made(options(figure)));
  std::printf("holes %.2f, with inner walls %.2f of the volume\n", alone / whole, walled / whole);
  EXPECT_NEAR(alone / whole, 1.0, 0.1);
  EXPECT_NEAR(walled / whole, 1.0, 0.1);
}

TEST_F(NewFigure, WhatIsInsideOutIsTurned) {
  const double whole = volume_of(plain());
  Figure figure;
  const Figure::Mesh body = figure.meshes[0];
  for (Triangle& t : figure.meshes[0].triangles) std::swap(t[1], t[2]);
  EXPECT_NEAR(volume_of(made(options(figure))) / whole, 1.0, 1e-6);
  // The hull that draws a toon's outline: the body inside out, 3 mm around it.
  Figure::Mesh& hull = figure.meshes[0];
  const std::vector<Vec3> normals = vertex_normals({body.positions, body.triangles});
  for (size_t i = 0; i < normals.size(); ++i) hull.positions[i] += 0.003 * normals[i];
  hull.name = "Outline";
  figure.meshes.push_back(body);
  const double outlined = volume_of(made(options(figure))) / whole;
  std::printf("with an outline %.3f of the volume\n", outlined);
  EXPECT_GE(outlined, 1.0 - 1e-6);
  EXPECT_LT(outlined, 1.2);
}

// Weights that were made by nearness give it to the arm that hangs beside it.
TEST_F(NewFigure, TheTrunksSideIsNoneOfTheArm) {
  Figure figure;
  const auto joint = [&](const std::string& name) {
    const auto has_name = [&](const Figure::Joint& one) { return one.name == name; };
    const auto at = std::find_if(figure.joints.begin(), figure.joints.end(), has_name);
    return static_cast<int>(at - figure.joints.begin());
  };
  const std::array<int, 2> arms = {joint("RightArm"), joint("LeftArm")};
  Figure::Mesh& mesh = figure.meshes[0];
  int given = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3& p = mesh.positions[i];
    const int side = p.x() > 0.0, arm = arms[side];
    if (mesh.share(i, arm, arm + 2) > 0.1 || p.y() < 1.0 || p.y() > 1.33) continue;
    mesh.joints[i] = {static_cast<std::uint8_t>(arm), 0, 0, 0};
    mesh.weights[i] = {1.0f, 0.0f, 0.0f, 0.0f};
    ++given;
  }
  EXPECT_GT(given, 50);
  const Model beside = made(options(figure));
  EXPECT_NEAR(volume_of(beside), volume_of(plain()), 0.03 * volume_of(plain()));
}

// Twice as thick, with room for four times as much: muscles that are not a man's in proportion take
// two thirds of what the template's take of theirs, and the rest is fat.
TEST_F(NewFigure, AThickArmHasMoreFat) {
  Figure figure;
  Figure::thin(2.0, figure.meshes[0]);
  const Model model = made(options(figure));
  const double more = volume_of(model) / volume_of(plain());
  std::printf("%.2f of the volume\n", more);
  EXPECT_GT(more, 2.5);
  EXPECT_LT(more, 3.5);
}

// Bound a centimetre or more behind the elbow's skin, as game characters' are: muscles had no room
// there, and were refused as too thin all over.
TEST_F(NewFigure, AnElbowBehindItsSkinHasRoomBehindIt) {
  Figure figure;
  for (Figure::Joint& joint : figure.joints) {
    if (joint.name.ends_with("ForeArm")) joint.place.z() -= 0.06;
  }
  const Model model = made(options(figure));
  const double share = volume_of(model) / volume_of(plain());
  std::printf("%.2f of the volume\n", share);
  EXPECT_GT(share, 0.8);
  EXPECT_LT(share, 1.4);
}

// The figure with upper arms and forearms apart, and another piece in the elbows between them,
// `share` as thick and so far above (m).
Figure in_pieces(double share, double above) {
  Figure figure;
  Figure::Mesh ball = figure.meshes[0];
  ball.name = "Ball";
  Figure::thin(share, ball);
  ball.cut([](const Vec3& p) { return std::abs(std::abs(p.x()) - 0.37) > 0.03; });
  for (Vec3& p : ball.positions) p.y() += above;
  Figure::Mesh& body = figure.meshes[0];
  std::erase_if(body.triangles, [&](const Triangle& t) {  // one that is cut leaves no strip
    return std::any_of(t.begin(), t.end(), [&](int i) {
      return std::abs(std::abs(body.positions[i].x()) - 0.37) < 0.015;
    });
  });
  figure.meshes.push_back(ball);
  return figure;
}

TEST_F(NewFigure, PiecesMakeOneArm) {
  const double whole = volume_of(plain());
  const Model model = made(options(in_pieces(0.6, 0.0)));
  std::printf("%.2f of the volume\n", volume_of(model) / whole);
  EXPECT_GT(volume_of(model) / whole, 0.6);
  EXPECT_LT(volume_of(model) / whole, 1.05);
}

// Pieces that go through each other are hard, and leave their muscles room to swell in: two thirds
// of what the template's take, where soft skin may have more.
TEST_F(NewFigure, MusclesUnderHardPiecesAreThinner) {
  const double soft = volume_of(made(options(in_pieces(0.95, 0.0))));
  const double hard = volume_of(made(options(in_pieces(0.95, 0.004))));
  std::printf("%.2f of the volume\n", hard / soft);
  EXPECT_GT(hard / soft, 0.8);
  EXPECT_LT(hard / soft, 0.95);
}

// From shoulder over elbow to wrist, of the figure over the template.
double length_of_arm() {
  const auto length = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b - a).norm() + (c - b).norm();
  };
  const Scene scene = read_scene(fs::path(THEW_SOURCE_DIR) / "assets/arm/arm.toml");
  const Skeleton skeleton = import_urdf(scene.rig, scene.folder);
  Pose rest;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), rest);
  const auto place = [&](const char* body) {
    return Vec3(rest[find_body(skeleton, body)].translation());
  };
  const Figure figure;
  return length(figure.joints[3].place, figure.joints[4].place, figure.joints[5].place) /
         length(place("humerus"), place("ulna"), place("hand"));
}

// A camera that stood where the flexion asked for saw such a walk leave the picture.
TEST_F(NewFigure, ACameraGoesAlongAndShowsTheArmsWhole) {
  Figure figure;
  figure.walk = {Vec3(0, 0, 0), Vec3(1.5, 0.1, 3)};
  const NewOptions walking = options(figure, "left");
  const std::vector<std::string> clip = {"rig.clip={ animation = \"Walk\" }", "scene.frames=1-25",
                                         "skin.enabled=false"};
  const Model model = built(walking, clip);
  const SceneRender render = read_scene(walking.out, clip).render;
  const std::vector<SceneView> views = frame_views(model, render);
  ASSERT_EQ(views.size(), 2u);  // skin and muscles, in register
  EXPECT_EQ(views[0].eye, views[1].eye);
  EXPECT_EQ(views[0].target, views[1].target);
  const int hip = find_body(model.skeleton, figure.joints[0].name);
  State state = initial_state(model);
  for (int frame = 1; frame <= 25; frame += 8) {
    drive_bones(model, (frame - 1) / model.fps, state);
    EXPECT_NEAR(state.pose[hip].translation().z(), (frame - 1) / 8.0, 0.2);
    const Camera camera =
        make_camera(view_at(views[0], frame), 1.0 * render.width / render.height, {});
    double farthest = 0.0;  // of half the picture's width or height
    const auto see = [&](const Vec3& p) {
      const Vec3 seen = camera.view_from_world * p;
      farthest = std::max({farthest, std::abs(seen.x() / seen.z()) / camera.tan_x,
                           std::abs(seen.y() / seen.z()) / camera.tan_y});
    };
    for (const BoneState& bone : state.bones) {
      for (const Point& p : bone.x) see(to_vec(p));
    }
    for (const Muscle& muscle : model.muscles) {
      Points x;
      carried_positions(muscle.shape, carry_pose(muscle.shape, state.pose), muscle.swells, x);
      for (const Point& p : x) see(to_vec(p));
    }
    EXPECT_NEAR(farthest, kFill, 0.01) << frame;
  }
}

// Contact holds some nodes where each step takes them out of: they rest all the same.
TEST_F(NewFigure, ComesToRestBeforeItsTimeToSettleIsOver) {
  Parallel parallel(1);
  State state = initial_state(plain());
  const Settled settled = settle(plain(), parallel, state);
  EXPECT_TRUE(settled.converged) << settled.speed << " m/s";
  EXPECT_LT(settled.seconds, 0.8 * plain().settle);
}

// Alike in the small and in the large: sizes, volumes, what the scene says of its size, and what
// the solver does with it.
TEST_F(NewFigure, ChildAndGiantAreTheSameArm) {
  for (const double size : {0.5, 8.0}) {
    Figure figure;
    figure.place([&](const Vec3& p) { return Vec3(size * p); });
    const Model model = made(options(figure));
    EXPECT_NEAR(model.size, size * length_of_arm(), 0.01 * size);
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      const double ratio = model.muscles[m].rest_volume / plain().muscles[m].rest_volume;
      EXPECT_NEAR(ratio / (size * size * size), 1.0, 1e-3) << model.muscles[m].name;
    }
  }
}

// The length of its arm over the template's, whose humerus measures 0.309 m to its 0.263.
TEST_F(NewFigure, AnArmsSizeIsItsLengthOverTheTemplates) { EXPECT_NEAR(plain().size, 0.85, 0.01); }

TEST_F(NewFigure, UnitsAreTheUsersToName) {
  for (const double unit : {0.01, 0.0254}) {
    Figure figure;
    figure.place([&](const Vec3& p) { return Vec3(p / unit); });
    const Model model = made(options(figure, "both", unit));
    EXPECT_NEAR(volume_of(model) / volume_of(plain()), 1.0, 1e-3);
  }
}

// Lying on its back, as a file with z up has it: the arms are the same.
TEST_F(NewFigure, ZUpIsAPersonLyingDown) {
  Figure figure;
  figure.place([](const Vec3& p) { return Vec3(p.x(), -p.z(), p.y()); });
  const Model model = made(options(figure));
  std::printf("%.2f of the volume\n", volume_of(model) / volume_of(plain()));
  EXPECT_NEAR(volume_of(model) / volume_of(plain()), 1.0, 0.1);
}

TEST_F(NewFigure, AHandThatIsNotThereGetsNoBones) {
  Figure figure;
  figure.meshes[0].cut([](const Vec3& p) { return p.x() > 0.53; });
  const Model model = made(options(figure));
  EXPECT_EQ(model.bones.size(), 9u);  // of ten the left hand's is missing
  for (const Bone& bone : model.bones) EXPECT_NE(bone.name, "hand_left");
  // Nor where there is no body for it, and the forearm's carries the hand.
  Figure without;
  without.joints[5].name = "Glove";
  without.joints[5].parent = 1;
  for (auto& joints : without.meshes[0].joints) {
    for (auto& joint : joints) joint = joint == 5 ? 4 : joint;
  }
  NewOptions handless = options(without);
  handless.out = folder / "handless.toml";
  const Model of_forearm = made(handless);
  EXPECT_EQ(of_forearm.bones.size(), 9u);
  std::printf("%.2f of the volume\n", volume_of(of_forearm) / volume_of(plain()));
  EXPECT_NEAR(volume_of(of_forearm) / volume_of(plain()), 1.0, 0.1);
}

// A hand on a goal of inverse kinematics hangs on the trunk, and so does its skin.
TEST_F(NewFigure, SkinThatTheArmDoesNotCarryIsTold) {
  Figure figure;
  figure.joints[5].parent = 1;
  testing::internal::CaptureStderr();
  made(options(figure));
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_HAS(said, "of the skin around the left forearm and hand hangs on bodies that they do not");
  EXPECT_HAS(said, figure.joints[5].name + "\" first: it stays behind");
  EXPECT_EQ(said.find("around the right"), std::string::npos) << said;
}

TEST_F(NewFigure, OneArmIsTakenAndTheOtherAskedFor) {
  Figure figure;
  figure.joints.resize(6);  // hips, chest and the left arm
  Figure::Mesh& mesh = figure.meshes[0];
  const Figure::Mesh whole = mesh;
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return std::any_of(t.begin(), t.end(), [&](int i) { return whole.share(i, 6, 9) > 0.0; });
  });
  for (auto& joints : mesh.joints) {
    for (auto& joint : joints) joint = joint > 5 ? 1 : joint;
  }
  EXPECT_EQ(made(options(figure, "left")).muscles.size(), 12u);
  NewOptions both = options(figure, "both");
  both.out = folder / "both.toml";
  EXPECT_HAS(refusal(both), "which body is the right humerus");
}

TEST_F(NewFigure, ThinArmsAreRefusedWithAPicture) {
  Figure figure;
  Figure::thin(0.2, figure.meshes[0]);
  const std::string said = refusal(options(figure));
  EXPECT_HAS(said, "too thin for muscles");
  EXPECT_HAS(said, why().string());
  EXPECT_HAS(read_whole(why(), 8 << 20), "too thin for muscles");
  EXPECT_FALSE(fs::exists(folder / "scene" / "muscles"));  // nothing is left lying about
}

// Bodies in the trunk's middle, taken for both upper arms.
TEST_F(NewFigure, ArmsInOnePlaceAreRefused) {
  NewOptions asked_for = options(Figure());
  asked_for.map = {{"left_humerus", "LeftShoulder"}, {"right_humerus", "RightShoulder"}};
  EXPECT_HAS(refusal(asked_for), "\"RightShoulder\" and \"LeftShoulder\" begin in one place");
}

TEST_F(NewFigure, ArmsWithoutSkinAreRefusedWithAPicture) {
  Figure figure;
  figure.meshes[0].cut([](const Vec3& p) { return p.x() > 0.2 && p.x() < 0.36; });
  const std::string said = refusal(options(figure));
  EXPECT_HAS(said, "the left upper arm: skin is found around its bone in");
  EXPECT_HAS(said, "of Body");
  EXPECT_HAS(read_whole(why(), 8 << 20), "skin is found around its bone");
}

// Of how far points lie apart along their longest line, how far they do across it.
double breadth(const std::vector<Vec3>& points) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - middle) * (p - middle).transpose();
  const Vec3 variances = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvalues();
  return std::sqrt(variances[1] / variances[2]);
}

// The fingers ended 60 mm beyond a short hand's; in one that comes to a point they were needles.
TEST_F(NewFigure, FingersEndInsideTheHand) {
  for (const double share : {1.0, 0.6}) {
    Figure figure;
    for (Vec3& p : figure.meshes[0].positions) {
      const double side = p.x() < 0.0 ? -1.0 : 1.0;
      const Vec3 wrist(0.53, 1.075, 0.02), left(side * p.x(), p.y(), p.z());
      if (left.x() < wrist.x()) continue;
      const Vec3 now = wrist + share * (left - wrist);
      p = Vec3(side * now.x(), now.y(), now.z());
    }
    const Model model = made_with_skin(options(figure));
    const TiedPose tied(model);
    const TriMesh shell = shell_of(model, 0);
    int hands = 0;
    for (size_t b = 0; b < model.bones.size(); ++b) {
      if (!model.bones[b].name.starts_with("hand")) continue;
      ++hands;
      double most = 0.0;
      for (const Vec3& x : tied.bones[b]) {
        if (winding(shell, x) < 0.5) most = std::max(most, distance(shell, x));
      }
      std::printf("%s, hand of %.1f: %.1f mm outside\n", model.bones[b].name.c_str(), share,
                  1e3 * most);
      EXPECT_LT(most, 2e-3);
      EXPECT_GT(breadth(tied.bones[b]), 0.2);  // the needles' was 0.1
    }
    EXPECT_EQ(hands, 2);
  }
}

}  // namespace
}  // namespace thew::tests
