// SPDX-License-Identifier: Apache-2.0
//
// A character's file as a scene's rig, and its own skin over muscles.
#include <gtest/gtest.h>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/character_rig.h"
#include "sim/solver/contacts.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class CharacterScene : public TempFolder {
 protected:
  // The robot with one muscle on its right arm; `more` is the rest of the scene.
  fs::path robot_scene(const std::string& rig, const std::string& more = "") {
    const fs::path robot = fs::path(THEW_SHARED_DATA) / "robot.glb";
    if (!fs::exists(robot)) return {};
    fs::copy_file(robot, folder / "robot.glb", fs::copy_options::overwrite_existing);
    return write(
        "scene.toml",
        "[rig]\nfile = \"robot.glb\"\n" + rig +
            "[[muscle]]\nname = \"a\"\npath = "
            "[[\"UpperArm.R\", 0, 0.1, 0.1], [\"LowerArm.R\", 0, 0.4, 0.1]]\nprofile = { around "
            "= 8, rings = 6, radius = [[0, 0.05]] }\n" +
            more);
  }
};

TEST_F(CharacterScene, AnimationMovesBodiesAndSkin) {
  const fs::path file = robot_scene("[rig.clip]\nanimation = \"Robot_Wave\"\n",
                                    "[skin]\nkind = \"skinned\"\n[scene]\nframes = \"1-8\"\n");
  if (file.empty()) GTEST_SKIP() << "robot.glb is not there";
  const Model model = build_model(read_scene(file));
  Parallel parallel(1);
  State state = initial_state(model);
  settle(model, parallel, state);
  StageSeconds seconds;
  step_frame(model, 0.25, parallel, state, seconds);
  const Character robot = import_character(folder / "robot.glb");
  const BodyClip* wave = nullptr;
  for (const BodyClip& clip : robot.animations) wave = clip.name == "Robot_Wave" ? &clip : wave;
  ASSERT_NE(wave, nullptr);
  std::vector<Affine> world;
  animated_bodies(robot, *wave, 0.25, world);
  for (int b = 0; b < robot.skeleton.size(); ++b) {
    EXPECT_LT((state.pose[b].translation() - world[b].translation()).norm(), 1e-12);
  }
  // Away from the muscle the skin is the user's own, in the user's order.
  Points x;
  skin_vertices(robot.skin, robot.mesh, world, x);
  ASSERT_EQ(x.size(), state.skin.x.size());
  int same = 0, moved = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const double d = (to_vec(x[i]) - to_vec(state.skin.x[i])).norm();
    same += d < 1e-12;
    moved += d > 1e-5;
    EXPECT_LT(d, 0.1);
  }
  EXPECT_GT(same, static_cast<int>(x.size()) / 2);
  EXPECT_EQ(moved, 0);  // its plates go through each other and are hard
}

TEST_F(CharacterScene, ItsOwnSkinIsNotAskedForItsVolume) {
  fs::copy_file(fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf",
                folder / "figure.gltf");
  const fs::path file = write("volume.toml",
                              "[rig]\nfile = \"figure.gltf\"\n"
                              "[skin]\nkind = \"skinned\"\nvolume = \"exact\"\n");
  EXPECT_EQ(usage_error(file),
            ":5: skin.volume is \"exact\", but the character's own skin need not be closed; remove "
            "it, or give a layer's mesh");
}

TEST_F(CharacterScene, HingeTurnsItsBodyFromTheBindPose) {
  const fs::path file = robot_scene(
      "[[rig.hinge]]\nname = \"elbow\"\nbody = \"LowerArm.R\"\naxis = [1, 0, 0]\nat_bind = 10\n"
      "[rig.clip]\nunit = \"deg\"\nkeys = { elbow = [[1, 40]] }\n",
      "[skin]\nkind = \"skinned\"\n");
  if (file.empty()) GTEST_SKIP() << "robot.glb is not there";
  const Model model = build_model(read_scene(file));
  Parallel parallel(1);
  State state = initial_state(model);
  settle(model, parallel, state);
  const int fore = find_body(model.skeleton, "LowerArm.R");
  const Transform bind = rigid_part(model.character->character.bind[fore]);
  const Mat3 turned = bind.linear().transpose() * state.pose[fore].linear();
  EXPECT_LT((turned - rotation_about(Vec3::UnitX(), 30 * kDegree)).norm(), 1e-9);
  EXPECT_LT((state.pose[fore].translation() - bind.translation()).norm(), 1e-9);
}

// The hinge is where it is in the bind pose, and what it turns is rolled.
TEST_F(CharacterScene, HingeTurnsItsBodyRolled) {
  fs::copy_file(THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf", folder / "figure.gltf");
  const Model model = build_model(read_scene(write(
      "scene.toml",
      "[rig]\nfile = \"figure.gltf\"\n[[rig.hinge]]\nname = \"elbow\"\nbody = \"RightForeArm\"\n"
      "axis = [1, 0, 0]\nat_bind = 10\nalong = [0, 2, 0]\nroll = -70\n"
      "[rig.clip]\nunit = \"deg\"\nkeys = { elbow = [[1, 40]] }\n[[muscle]]\nname = \"a\"\npath = "
      "[[\"RightArm\", 0, 0, 0.02], [\"RightForeArm\", 0.1, 0, 0.02]]\n"
      "profile = { around = 8, rings = 6, radius = [[0, 0.01]] }\n")));
  Parallel parallel(1);
  State state = initial_state(model);
  settle(model, parallel, state);
  const int fore = find_body(model.skeleton, "RightForeArm");
  const Transform bind = rigid_part(model.character->character.bind[fore]);
  const Mat3 turned = bind.linear().transpose() * state.pose[fore].linear();
  const Mat3 expected =
      rotation_about(Vec3::UnitX(), 30 * kDegree) * rotation_about(Vec3::UnitY(), -70 * kDegree);
  EXPECT_LT((turned - expected).norm(), 1e-9);
  EXPECT_LT((state.pose[fore].translation() - bind.translation()).norm(), 1e-9);
}

// The hinge bends both bones; what the body rolls besides turns the radius about its own line.
TEST_F(CharacterScene, RadiusTurnsAboutTheUlna) {
  fs::copy_file(THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf", folder / "figure.gltf");
  const auto scene = [&](const std::string& ulna, const std::string& wrist) {
    return read_scene(write(
        "scene.toml",
        "[rig]\nfile = \"figure.gltf\"\n[[rig.hinge]]\nname = \"elbow\"\nbody = \"RightForeArm\"\n"
        "axis = [1, 0.1, 0]\nat_bind = 10\nforearm = { ulna = \"" +
            ulna + "\", radius = \"r\", head = [0.01, 0.02, 0], wrist = " + wrist +
            " }\n[rig.clip]\nunit = \"deg\"\nkeys = { elbow = [[1, 40]] }\n[[muscle]]\nname = "
            "\"a\"\npath = [[\"RightArm\", 0, 0, 0.02], [\"u\", 0, 0.1, 0.02]]\nprofile = { around "
            "= 8, rings = 6, radius = [[0, 0.01]] }\n"));
  };
  const Model model = build_model(scene("u", "[0, 0.25, 0]"));
  const Forearm& forearm = model.character->forearms.at(0);
  const Skeleton& skeleton = model.skeleton;
  EXPECT_EQ(find_body(skeleton, "u"), forearm.ulna);
  Pose pose;
  std::vector<double> joints(skeleton.size(), 0.0);
  joints[forearm.body] = 110.0 * kDegree;
  forward_kinematics(skeleton, joints, pose);
  const Transform bent = pose[forearm.body];
  pose_forearm(skeleton, forearm, pose);
  EXPECT_LT((pose[forearm.ulna].matrix() - bent.matrix()).norm(), 1e-12);
  EXPECT_LT((pose[forearm.radius].matrix() - bent.matrix()).norm(), 1e-12);
  pose[forearm.body].linear() = bent.linear() * rotation_about(Vec3::UnitY(), 130.0 * kDegree);
  pose_forearm(skeleton, forearm, pose);
  EXPECT_LT((pose[forearm.ulna].matrix() - bent.matrix()).norm(), 1e-12);
  const Transform& radius = pose[forearm.radius];
  EXPECT_LT((radius * forearm.head - bent * forearm.head).norm(), 1e-12);
  EXPECT_LT((radius * forearm.wrist - pose[forearm.body] * forearm.wrist).norm(), 1e-12);
  const double turned = 0.5 * ((bent.linear().transpose() * radius.linear()).trace() - 1.0);
  EXPECT_NEAR(turned, sin_cos(130.0 * kDegree).cos, 1e-12);
  const auto message = [&](const std::string& ulna, const std::string& wrist) {
    try {
      build_model(scene(ulna, wrist));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_HAS(message("RightHand", "[0, 0.25, 0]"), "there is a body \"RightHand\" already");
  EXPECT_HAS(message("u", "[0.01, 0.02, 0]"), "give another place");
}

// Muscles are made where the arm hangs; the keys raise it to where it is bound, with the blade, and
// there the skin is the user's.
TEST_F(CharacterScene, ScapulaTurnsWithTheShoulder) {
  fs::copy_file(THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf", folder / "figure.gltf");
  const auto scene = [&](const std::string& on) {
    return read_scene(write(
        "scene.toml",
        "[rig]\nfile = \"figure.gltf\"\n[[rig.hinge]]\nname = \"shoulder\"\nbody = \"RightArm\"\n"
        "axis = [0, 0, 1]\nat_bind = 50\nscapula = { body = \"blade\", on = \"" +
            on +
            "\", axis = [0, 0, 1], hanging = [1, -1, 0], share = 0.5 }\n[rig.clip]\nunit = "
            "\"deg\"\nkeys = { shoulder = [[1, 50]] }\n[[muscle]]\nname = \"a\"\npath = "
            "[[\"blade\", "
            "0, 0, 0.02], [\"RightArm\", 0.1, 0, 0.02]]\nprofile = { around = 8, rings = 6, radius "
            "= "
            "[[0, 0.01]] }\n[skin]\nkind = \"skinned\"\n"));
  };
  const Model model = build_model(scene("RightShoulder"));
  Parallel parallel(1);
  State state = initial_state(model);
  const int arm = find_body(model.skeleton, "RightArm"), blade = find_body(model.skeleton, "blade");
  const int on = find_body(model.skeleton, "RightShoulder");
  EXPECT_LT((state.pose[blade].matrix() - state.pose[on].matrix()).norm(), 1e-12);
  settle(model, parallel, state);
  const Transform bind = rigid_part(model.character->character.bind[arm]);
  EXPECT_LT((state.pose[arm].matrix() - bind.matrix()).norm(), 1e-9);
  const Mat3 turn = state.pose[on].linear().transpose() * state.pose[blade].linear();
  EXPECT_GT((turn - Mat3::Identity()).norm(), 0.05);
  const Character& character = model.character->character;
  for (size_t i = 0; i < character.mesh.vertices.size(); ++i) {
    EXPECT_LT((to_vec(model.skinned->rest[i]) - character.mesh.vertices[i]).norm(), 1e-9);
  }
  try {
    build_model(scene("RightShoulde"));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_HAS(std::string(error.what()), "did you mean \"RightShoulder\"");
  }
}

TEST_F(CharacterScene, SkinAtRestIsTheUsersSkin) {
  const fs::path file = robot_scene("", "[skin]\nkind = \"skinned\"\n");
  if (file.empty()) GTEST_SKIP() << "robot.glb is not there";
  const Model model = build_model(read_scene(file));
  State state = initial_state(model);
  const SkinnedSkin& skin = *model.skinned;
  std::vector<Collider> felt;
  set_felt(model, state, felt);
  step_skinned(skin, model.character->rest, felt, {}, state.layer, state.skin);
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    ASSERT_LT((to_vec(state.skin.x[i]) - model.character->character.mesh.vertices[i]).norm(), 3e-6);
  }
  EXPECT_TRUE(skin.nodes.empty());  // likewise
}

TEST_F(CharacterScene, SaysWhatItHasWhereANameIsWrong) {
  const auto message = [&](const std::string& rig, const std::string& more = "") {
    const fs::path file = robot_scene(rig, more);
    if (file.empty()) return std::string("not there");
    try {
      build_model(read_scene(file));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string wave = message("[rig.clip]\nanimation = \"Robot_Wawe\"\n");
  if (wave == "not there") GTEST_SKIP() << "robot.glb is not there";
  EXPECT_HAS(wave, "scene.toml:4");
  EXPECT_HAS(wave, "did you mean \"Robot_Wave\"");
  EXPECT_HAS(message("[[rig.hinge]]\nname = \"e\"\nbody = \"LowerArmR\"\naxis = [1, 0, 0]\n"),
             "did you mean \"LowerArm.R\"");
  EXPECT_HAS(message("[rig.clip]\nanimation = \"Robot_Wave\"\nfile = \"x.bvh\"\n"), "remove it");
  EXPECT_HAS(message("hinges = 1\n"), "hinge");
}

}  // namespace
}  // namespace thew::tests
