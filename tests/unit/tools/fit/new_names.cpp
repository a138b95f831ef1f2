// SPDX-License-Identifier: Apache-2.0
//
// The arms of other people's skeletons, by the names that their tools give.
#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "rig/character_bones.h"
#include "rig/skeleton.h"
#include "tools/fit/arm.h"

namespace thew::tests {
namespace {

// A trunk with one chain of these bodies, each 0.2 m below the one before.
Character chain_of(const std::vector<std::string>& names) {
  Character character;
  std::vector<std::string> all = {"Root"};
  all.insert(all.end(), names.begin(), names.end());
  for (size_t i = 0; i < all.size(); ++i) {
    character.skeleton.body_names.push_back(all[i]);
    character.skeleton.parent.push_back(static_cast<int>(i) - 1);
    Affine at = Affine::Identity();
    at.translation() = Vec3(0.2, 2.0 - 0.2 * static_cast<double>(i), 0.0);
    character.bind.push_back(at);
    character.skin.links.push_back({static_cast<int>(i), at.inverse()});
  }
  return character;
}

struct Names {
  const char* tool;
  std::vector<std::string> chain;          // clavicle first
  int humerus = 1, forearm = 2, hand = 3;  // places in it
};

TEST(NewNames, OfTheToolsThatMakeCharacters) {
  const std::vector<Names> tools = {
      {"Mixamo",
       {"mixamorig:RightShoulder", "mixamorig:RightArm", "mixamorig:RightForeArm",
        "mixamorig:RightHand"}},
      {"Mixamo, second",
       {"mixamorig1:RightShoulder", "mixamorig1:RightArm", "mixamorig1:RightForeArm",
        "mixamorig1:RightHand"}},
      {"HumanIK",
       {"Character1_RightShoulder", "Character1_RightArm", "Character1_RightForeArm",
        "Character1_RightHand"}},
      {"VRM", {"J_Bip_R_Shoulder", "J_Bip_R_UpperArm", "J_Bip_R_LowerArm", "J_Bip_R_Hand"}},
      {"VRM's own words", {"rightShoulder", "rightUpperArm", "rightLowerArm", "rightHand"}},
      {"Rigify", {"shoulder.R", "upper_arm.R", "forearm.R", "hand.R"}},
      {"Rigify's deforming bones",
       {"DEF-shoulder.R", "DEF-upper_arm.R", "DEF-upper_arm.R.001", "DEF-forearm.R",
        "DEF-forearm.R.001", "DEF-hand.R"},
       1,
       3,
       5},
      {"Red Eclipse",
       {"shoulder.R", "upper_arm.R.01", "upper_arm.R.02", "forearm.R.01", "forearm.R.02", "hand.R"},
       1,
       3,
       5},
      {"Character Creator",
       {"CC_Base_R_Clavicle", "CC_Base_R_Upperarm", "CC_Base_R_Forearm", "CC_Base_R_Hand"}},
      {"Daz Genesis 9", {"r_shoulder", "r_upperarm", "r_forearm", "r_hand"}},
      {"Daz Genesis 8",
       {"rCollar", "rShldrBend", "rShldrTwist", "rForearmBend", "rForearmTwist", "rHand"},
       1,
       3,
       5},
      {"AdvancedSkeleton",
       {"Scapula_R", "Shoulder_R", "ShoulderPart1_R", "Elbow_R", "ElbowPart1_R", "Wrist_R"},
       1,
       3,
       5},
      {"Maya's joints", {"R_Clavicle_JNT", "R_Shoulder_JNT", "R_Elbow_JNT", "R_Wrist_JNT"}},
      {"Synty", {"Clavicle_R", "Shoulder_R", "Elbow_R", "Hand_R"}},
      {"SMPL", {"R_Collar", "R_Shoulder", "R_Elbow", "R_Wrist", "R_Hand"}},
      {"SMPL-X", {"right_collar", "right_shoulder", "right_elbow", "right_wrist"}},
      {"Second Life", {"mCollarRight", "mShoulderRight", "mElbowRight", "mWristRight"}},
      {"Source", {"bip_collar_R", "bip_upperArm_R", "bip_lowerArm_R", "bip_hand_R"}},
      {"ARKit",
       {"right_shoulder_1_joint", "right_arm_joint", "right_forearm_joint", "right_hand_joint"}},
      {"MikuMikuDance",
       {"右肩", "右腕", "右腕捩", "右ひじ", "右手捩", "右手首", "右中指１"},
       1,
       3,
       5},
      {"MikuMikuDance through Blender", {"肩.R", "腕.R", "ひじ.R", "手首.R"}},
      {"Xsens", {"Right Shoulder", "Right Upper Arm", "Right Forearm", "Right Hand"}},
      {"Auto-Rig Pro", {"shoulder.r", "arm_stretch.r", "forearm_stretch.r", "hand.r"}},
      {"Roblox", {"UpperTorso", "RightUpperArm", "RightLowerArm", "RightHand"}},
      {"Castle Game Engine's humanoid", {"ToArm_R", "Arm_R", "Forearm_R", "Hand_R"}},
      {"MakeHuman",
       {"clavicle.R", "shoulder01.R", "upperarm01.R", "upperarm02.R", "lowerarm01.R",
        "lowerarm02.R", "wrist.R"},
       2,
       4,
       6},
      {"MakeHuman of 2013",
       {"clavicle_R", "shoulder01_R", "shoulder02_R", "upperarm02_R", "lowerarm01_R",
        "lowerarm02_R", "wrist_R"},
       2,
       4,
       6},
      {"Unreal",
       {"clavicle_r", "upperarm_r", "upperarm_twist_01_r", "lowerarm_r", "lowerarm_twist_01_r",
        "hand_r"},
       1,
       3,
       5},
      {"VRoid, as VRM 0.x",
       {"J_Bip_R_Shoulder", "J_Bip_R_UpperArm", "J_Bip_R_LowerArm", "J_Bip_R_Hand"}},
      {"Mixamo, no prefix", {"RightShoulder", "RightArm", "RightForeArm", "RightHand"}},
      {"Rigify's halves",
       {"DEF-shoulder.R", "DEF-upper_arm.R", "DEF-upper_arm.R.001", "DEF-forearm.R",
        "DEF-forearm.R.001", "DEF-hand.R", "DEF-f_index.01.R"},
       1,
       3,
       5},
      {"Biped, of 3ds Max 2010",
       {"Bip001 R Clavicle", "Bip001 R UpperArm", "Bip001 R Forearm", "Bip001 R Hand"}},
      {"Daz, Genesis 3", {"rCollar", "rShldrBend", "rForearmBend", "rHand"}},
      {"Poser", {"RightCollar", "RightShoulder", "RightElbow", "RightWrist"}},
      {"Poser, short", {"rCollar", "rShldr", "rForeArm", "rHand"}},
      {"capitals", {"RShoulder", "RArm", "RForeArm", "RHand"}},
      {"the side between", {"clavicle_right", "arm_right_upper", "arm_right_lower", "hand_right"}},
      {"Biped", {"Bip01 R Clavicle", "Bip01 R UpperArm", "Bip01 R Forearm", "Bip01 R Hand"}},
      {"Daz",
       {"rCollar", "rShldrBend", "rShldrTwist", "rForearmBend", "rForearmTwist", "rHand"},
       1,
       3,
       5},
      {"CMU", {"RightShoulder", "RightArm", "RightForeArm", "RightHand"}},
      {"MakeHuman's walk", {"Shoulder_R", "UpArm_R", "LoArm_R", "Hand_R"}},
      {"assimp's FBX",
       {"RightShoulder", "RightArm_$AssimpFbx$_PreRotation", "RightArm",
        "RightForeArm_$AssimpFbx$_PreRotation", "RightForeArm", "RightHand"},
       2,
       4,
       5}};
  for (const auto& [tool, chain, humerus, forearm, hand] : tools) {
    SCOPED_TRACE(tool);
    std::vector<std::string> notes;
    const std::vector<ArmBodies> arms =
        find_arms(chain_of(chain), "right", {}, "character.glb", notes);
    ASSERT_EQ(arms.size(), 1u);
    EXPECT_FALSE(arms[0].left);
    EXPECT_EQ(arms[0].humerus, humerus + 1);
    EXPECT_EQ(arms[0].forearm, forearm + 1);
    EXPECT_EQ(arms[0].hand, hand + 1);
    EXPECT_TRUE(notes.empty()) << notes[0];  // by name, not by shape
  }
}

// Blender counts the bodies that are drawn out of one.
TEST(NewNames, TheUpperArmAloneIsNamed) {
  for (const auto& chain : {std::vector<std::string>{"Chest", "Arm.R", "Arm.R.001", "Arm.R.002"},
                            {"Chest", "Arm1.R", "Arm2.R", "Arm3.R"}}) {
    std::vector<std::string> notes;
    const std::vector<ArmBodies> arms =
        find_arms(chain_of(chain), "right", {}, "character.glb", notes);
    ASSERT_EQ(arms.size(), 1u);
    EXPECT_EQ(arms[0].humerus, 2);
    EXPECT_EQ(arms[0].forearm, 3);
    EXPECT_EQ(arms[0].hand, 4);
    ASSERT_EQ(notes.size(), 1u);  // which were taken
    EXPECT_NE(notes[0].find("forearm Arm"), std::string::npos) << notes[0];
  }
}

// A body from the trunk's middle to the shoulder has an arm's name in its own.
TEST(NewNames, AnArmBeginsBesideTheTrunk) {
  Character character = chain_of({"Trunk", "TrunkToArm.R", "Arm1.R", "Arm2.R", "End"});
  Skeleton& skeleton = character.skeleton;
  for (const int of : {2, 3, 4, 5}) {
    std::string name = skeleton.body_names[of];
    if (name.ends_with("R")) name.back() = 'L';
    skeleton.body_names.push_back(name);
    skeleton.parent.push_back(of == 2 ? 1 : skeleton.size() - 2);
    Affine at = character.bind[of];
    character.bind[of].translation().x() -= of == 2 ? 0.0 : 0.2;
    at.translation().x() += of == 2 ? 0.0 : 0.2;
    character.bind.push_back(at);
    character.skin.links.push_back({skeleton.size() - 1, at.inverse()});
  }
  std::vector<std::string> notes;
  const std::vector<ArmBodies> arms = find_arms(character, "both", {}, "character.glb", notes);
  ASSERT_EQ(arms.size(), 2u);
  EXPECT_EQ(skeleton.body_names[arms[0].humerus], "Arm1.R");
  EXPECT_EQ(skeleton.body_names[arms[1].humerus], "Arm1.L");
  EXPECT_EQ(skeleton.body_names[arms[1].forearm], "Arm2.L");
}

// A rigid piece of skin on a body, whose own origin may lie anywhere.
TEST(NewNames, APieceOfAnArmIsNoUpperArm) {
  Character character =
      chain_of({"RightShoulder", "RightArm", "P_RightArm", "RightForeArm", "RightHand"});
  character.skeleton.parent[4] = 2;
  character.bind[3] = Affine::Identity();
  Skeleton& skeleton = character.skeleton;
  skeleton.body_names.insert(skeleton.body_names.end(), {"LeftShoulder", "LeftArm"});
  skeleton.parent.insert(skeleton.parent.end(), {0, 6});
  for (const int of : {1, 2}) {
    Affine at = character.bind[of];
    at.translation().x() -= 0.4;
    character.bind.push_back(at);
  }
  std::vector<std::string> notes;
  const std::vector<ArmBodies> arms = find_arms(character, "right", {}, "character.fbx", notes);
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_EQ(arms[0].humerus, 2);
  EXPECT_EQ(arms[0].forearm, 4);
}

// Half of a forearm is no hand, as where a rig ends at the wrist.
TEST(NewNames, AHalfOfTheForearmIsNoHand) {
  Character character = chain_of({"RightShoulder", "upperarm.R", "lowerarm01.R", "lowerarm02.R"});
  character.bind[4].translation().y() += 0.1;
  character.mesh.vertices = {{0.2, 1.4, 0.03}, {0.2, 1.3, -0.03}, {0.2, 1.22, 0.0}};
  for (int i = 0; i < 3; ++i) {
    character.skin.link.push_back(i == 0 ? 3 : 4);
    character.skin.weight.push_back(1.0);
  }
  character.skin.first = {0, 1, 2, 3};
  std::vector<std::string> notes;
  const std::vector<ArmBodies> arms = find_arms(character, "right", {}, "character.glb", notes);
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_FALSE(arms[0].has_hand());
  EXPECT_NEAR(arms[0].wrist.y(), -0.2 / 1.2, 1e-9);  // m: as long as a person's
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("ends with the body lowerarm01.R"), std::string::npos) << notes[0];
}

// Rigify's bones that control a rig have the names of those that deform its skin, and of these each
// limb's first hangs on the root where the others are left out.
TEST(NewNames, BonesThatDeformBeforeThoseThatControl) {
  Character character =
      chain_of({"upper_arm_fk.R", "forearm_fk.R", "hand_fk.R", "DEF-shoulder.R", "DEF-upper_arm.R",
                "DEF-upper_arm.R.001", "DEF-forearm.R", "DEF-forearm.R.001", "DEF-hand.R"});
  character.skeleton.parent[4] = character.skeleton.parent[5] = 0;
  for (int body = 4; body <= 9; ++body) {
    character.bind[body].translation().y() = 2.4 - 0.2 * body;
    character.mesh.vertices.push_back(character.bind[body].translation());
    character.skin.link.push_back(body);
    character.skin.weight.push_back(1.0);
  }
  character.skin.first = {0, 1, 2, 3, 4, 5, 6};
  std::vector<std::string> notes;
  const std::vector<ArmBodies> arms = find_arms(character, "right", {}, "character.glb", notes);
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_EQ(arms[0].clavicle, 4);
  EXPECT_EQ(arms[0].humerus, 5);
  EXPECT_EQ(arms[0].forearm, 7);
  EXPECT_EQ(arms[0].hand, 9);
  EXPECT_TRUE(notes.empty()) << notes[0];
  EXPECT_EQ(human_bodies(character).at({BoneKind::kForearm, -1}), 7);
}

// A person with arms stretched out and names that say nothing. The left arm's bodies come first.
struct Unnamed {
  Character character;
  std::map<std::string, int> of;  // body by what it is

  int add(const std::string& what, int on, const Vec3& at) {
    const int body = character.skeleton.size();
    character.skeleton.body_names.push_back("Bone." + std::to_string(body));
    character.skeleton.parent.push_back(on);
    Affine place = Affine::Identity();
    place.translation() = at;
    character.bind.push_back(place);
    character.skin.links.push_back({body, place.inverse()});
    return of[what] = body;
  }
  // `halves`: of a limb's bones, the second of which twists. `flat`: limbs hang on the root.
  Unnamed(bool halves, bool flat, bool legs) {
    const int hips = add("hips", -1, {0.0, 1.0, 0.0}), chest = add("chest", hips, {0.0, 1.35, 0.0});
    for (const double side : {1.0, -1.0}) {
      const std::string which = side > 0.0 ? "left " : "right ";
      const auto chain = [&](int on, const std::vector<std::pair<std::string, Vec3>>& bodies) {
        for (const auto& [what, at] : bodies) {
          if (what.ends_with("half") && !halves) continue;
          on = add(which + what, on, {side * at.x(), at.y(), at.z()});
        }
        return on;
      };
      if (!flat) chain(chest, {{"clavicle", {0.03, 1.42, 0.0}}});
      const int wrist = chain(flat ? hips : of[which + "clavicle"], {{"humerus", {0.18, 1.4, 0.0}},
                                                                     {"half", {0.32, 1.4, 0.0}},
                                                                     {"forearm", {0.46, 1.4, 0.0}},
                                                                     {"half", {0.58, 1.4, 0.0}},
                                                                     {"hand", {0.7, 1.4, 0.0}}});
      for (const double z : {-0.03, 0.0, 0.03}) {
        chain(wrist, {{"knuckle", {0.79, 1.4, z}}, {"tip", {0.85, 1.4, z}}});
      }
      if (!legs) continue;
      chain(hips, {{"thigh", {0.1, 0.95, 0.0}},
                   {"half", {0.1, 0.73, 0.0}},
                   {"shin", {0.1, 0.5, 0.0}},
                   {"half", {0.1, 0.29, 0.0}},
                   {"foot", {0.1, 0.08, 0.0}},
                   {"toe", {0.1, 0.02, 0.12}}});
    }
  }
};

TEST(NewNames, OfABonesBodiesInALineOneLimb) {
  for (const auto& [halves, flat, legs] : {std::tuple(false, false, true),
                                           {true, false, true},
                                           {true, true, true},
                                           {true, false, false}}) {
    SCOPED_TRACE(std::to_string(halves) + std::to_string(flat) + std::to_string(legs));
    const Unnamed person(halves, flat, legs);
    std::vector<std::string> notes;
    const std::vector<ArmBodies> arms =
        find_arms(person.character, "both", {}, "character.glb", notes);
    ASSERT_EQ(arms.size(), 2u);
    for (const ArmBodies& arm : arms) {
      const std::string which = arm.left ? "left " : "right ";
      EXPECT_EQ(arm.humerus, person.of.at(which + "humerus"));
      EXPECT_EQ(arm.forearm, person.of.at(which + "forearm"));
      EXPECT_EQ(arm.hand, person.of.at(which + "hand"));
    }
  }
}

// Words of no language that is known, on a person who looks along -z and has no feet.
TEST(NewNames, WhereTheShapeTellsTheArmsNamesTellTheirSides) {
  Unnamed person(false, false, false);
  for (const auto& [what, body] : person.of) {
    if (what.find(' ') == what.npos) continue;
    // What the shape alone takes for left is right.
    const char* side = what.starts_with("left") ? ".R" : ".L";
    const bool limb = what.ends_with("humerus") || what.ends_with("forearm");
    if (limb) person.character.skeleton.body_names[body] = "bras" + std::to_string(body) + side;
  }
  std::vector<std::string> notes;
  const auto arms = find_arms(person.character, "both", {}, "character.glb", notes);
  ASSERT_EQ(arms.size(), 2u);
  for (const ArmBodies& arm : arms) {
    EXPECT_EQ(arm.humerus, person.of.at(arm.left ? "right humerus" : "left humerus"));
    EXPECT_EQ(arm.hand, person.of.at(arm.left ? "right hand" : "left hand"));
  }
}

TEST(NewNames, OneArmOfPlainNames) {
  const Character character = chain_of({"Shoulder", "UpperArm", "Forearm", "Hand"});
  std::vector<std::string> notes;
  for (const char* side : {"right", "left"}) {
    const auto arms = find_arms(character, side, {}, "arm.glb", notes);
    ASSERT_EQ(arms.size(), 1u);
    EXPECT_EQ(arms[0].humerus, 2);
    EXPECT_EQ(arms[0].forearm, 3);
    EXPECT_EQ(arms[0].hand, 4);
  }
  EXPECT_TRUE(notes.empty()) << notes[0];
  EXPECT_THROW(find_arms(character, "both", {}, "arm.glb", notes), Error);
  // One that has a side is not the other's.
  EXPECT_THROW(find_arms(chain_of({"LeftArm", "LeftForeArm", "LeftHand"}), "right", {}, "x", notes),
               Error);
}

TEST(NewNames, VrmsMapBeforeNames) {
  Character character = chain_of({"RightArm", "a", "b", "c", "d"});
  character.humanoid = {{"rightHand", 5}, {"rightLowerArm", 4}, {"rightUpperArm", 3}};
  std::vector<std::string> notes;
  const auto arms = find_arms(character, "right", {}, "x.vrm", notes);
  EXPECT_EQ(arms[0].humerus, 3);
  EXPECT_EQ(arms[0].forearm, 4);
  EXPECT_EQ(arms[0].hand, 5);
  EXPECT_TRUE(notes.empty()) << notes[0];
}

TEST(NewNames, WhatTheShapeDecidesIsSaidInOneLine) {
  const Character character =
      chain_of({"RightShoulder", "RightArm", "RightFore_$AssimpFbx$_PreRotation", "limb", "end"});
  std::vector<std::string> notes;
  const auto arms = find_arms(character, "right", {}, "x", notes);
  EXPECT_EQ(arms[0].forearm, 4);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("names do not tell: forearm limb, hand end;"), std::string::npos)
      << notes[0];
}

}  // namespace
}  // namespace thew::tests
