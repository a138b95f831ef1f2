// SPDX-License-Identifier: Apache-2.0
//
// Motion of one skeleton on another: whatever the names of the bodies and their rest pose, upper
// arms, forearms, thighs and shins point in the same directions as those of the motion.
#include <gtest/gtest.h>

#include "rig/character_bones.h"
#include "rig/import/character_import.h"
#include "rig/math.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

struct Words {
  const char *hips, *chest, *clavicle, *humerus, *forearm, *hand, *thigh, *shin, *foot;
};
// "%" stands for the side.
constexpr Words kMixamo = {"mixamorig:Hips",   "mixamorig:Spine",    "mixamorig:%Shoulder",
                           "mixamorig:%Arm",   "mixamorig:%ForeArm", "mixamorig:%Hand",
                           "mixamorig:%UpLeg", "mixamorig:%Leg",     "mixamorig:%Foot"};
constexpr Words kPoser = {"hip",    "chest", "%Collar", "%Shoulder", "%Elbow",
                          "%Wrist", "%Hip",  "%Knee",   "%Ankle"};
constexpr Words kVrm = {"hips",  "spine",     "%Shoulder", "%UpperArm", "%LowerArm",
                        "%Hand", "%UpperLeg", "%LowerLeg", "%Foot"};

std::string named(const char* word, bool left) {
  std::string name = word;
  const size_t at = name.find('%');
  if (at != name.npos) name.replace(at, 1, left ? "Left" : "Right");
  return name;
}

// A person in metres times `size`, its arms `drop` rad below the horizontal, turned by `axes`.
Character person(const Words& words, double drop, double size = 1.0,
                 const Mat3& axes = Mat3::Identity()) {
  Character character;
  const auto add = [&](const std::string& name, int parent, const Vec3& at) {
    Affine world = Affine::Identity();
    world.linear() = axes;
    world.translation() = axes * (size * at);
    character.skeleton.body_names.push_back(name);
    character.skeleton.parent.push_back(parent);
    character.bind.push_back(world);
    character.rest.push_back(parent < 0 ? world : character.bind[parent].inverse() * world);
    character.skeleton.joint_in_parent.push_back(Transform(character.rest.back().matrix()));
    character.skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
    character.skeleton.joint_axes.push_back(Vec3::UnitX());
    return character.skeleton.size() - 1;
  };
  const int hips = add(words.hips, -1, Vec3(0, 1, 0)),
            chest = add(words.chest, hips, Vec3(0, 1.3, 0));
  for (const bool left : {true, false}) {
    const double s = left ? 1.0 : -1.0;
    const Vec3 along(s * sin_cos(kPi / 2 - drop).sin, -sin_cos(drop).sin, 0),
        shoulder(s * 0.2, 1.4, 0);
    const int clavicle = add(named(words.clavicle, left), chest, Vec3(s * 0.05, 1.4, 0));
    const int humerus = add(named(words.humerus, left), clavicle, shoulder);
    const int forearm = add(named(words.forearm, left), humerus, shoulder + 0.3 * along);
    add(named(words.hand, left), forearm, shoulder + 0.55 * along);
    const int thigh = add(named(words.thigh, left), hips, Vec3(s * 0.1, 0.95, 0));
    const int shin = add(named(words.shin, left), thigh, Vec3(s * 0.1, 0.5, 0));
    add(named(words.foot, left), shin, Vec3(s * 0.1, 0.1, 0));
  }
  return character;
}

int body_of(const Character& character, const char* word, bool left) {
  const int body = find_body(character.skeleton, named(word, left));
  EXPECT_GE(body, 0) << named(word, left);
  return body;
}

// Local rotations about axes that do not commute, at 60 keys a second.
BodyClip wave(const Character& of, const Words& words) {
  BodyClip clip;
  clip.duration = 1.0;
  const std::vector<std::pair<const char*, Vec3>> turns = {
      {words.hips, Vec3(0.1, 0.7, 0.2)},     {words.chest, Vec3(0.3, 0.1, 0.0)},
      {words.humerus, Vec3(0.4, 0.9, -1.1)}, {words.forearm, Vec3(0.2, 1.4, 0.1)},
      {words.thigh, Vec3(-0.8, 0.1, 0.2)},   {words.shin, Vec3(1.0, 0.0, 0.1)}};
  for (const auto& [word, turn] : turns) {
    for (const bool left : {true, false}) {
      if (!left && std::string(word).find('%') == std::string::npos) continue;
      BodyTrack track;
      track.body = body_of(of, word, left);
      const Mat3 rest = of.rest[track.body].linear();
      for (int k = 0; k <= 60; ++k) {
        track.rotation.times.push_back(k / 60.0);
        track.rotation.values.emplace_back(
            rotation_about(turn.normalized(), turn.norm() * k / 60.0) * rest);
      }
      clip.tracks.push_back(std::move(track));
    }
  }
  return clip;
}

// Largest angle (rad) between the directions of the limbs, each in its own axes.
double worst_angle(const Character& from, const Words& theirs, const BodyClip& clip,
                   const Character& to, const Words& ours, const BodyClip& carried, double time,
                   const Mat3& axes = Mat3::Identity()) {
  std::vector<Affine> a, b;
  animated_bodies(from, clip, time, a);
  animated_bodies(to, carried, time, b);
  double worst = 0.0;
  for (const auto& limb :
       {std::pair(&Words::humerus, &Words::forearm), std::pair(&Words::forearm, &Words::hand),
        std::pair(&Words::thigh, &Words::shin), std::pair(&Words::shin, &Words::foot)}) {
    for (const bool left : {true, false}) {
      const auto along = [&](const Character& of, const std::vector<Affine>& world,
                             const Words& words) {
        return Vec3((world[body_of(of, words.*limb.second, left)].translation() -
                     world[body_of(of, words.*limb.first, left)].translation())
                        .normalized());
      };
      const Vec3 p = axes.transpose() * along(from, a, theirs), q = along(to, b, ours);
      worst = std::max(worst, arc_tan2(p.cross(q).norm(), p.dot(q)));
    }
  }
  return worst;
}

TEST(Retarget, LimbsPointWhereTheirsDo) {
  const Character t_pose = person(kMixamo, 0.0);
  const BodyClip clip = wave(t_pose, kMixamo);
  for (const Words& words : {kMixamo, kPoser, kVrm}) {
    for (const double drop : {0.0, 45 * kDegree}) {  // T and A
      SCOPED_TRACE(std::string(words.humerus) + " " + std::to_string(drop));
      const Character to = person(words, drop, 0.6);
      std::vector<std::string> warnings;
      const BodyClip carried = retarget(t_pose, clip, to, {}, "x", warnings);
      EXPECT_EQ(carried.tracks.size(), to.skeleton.body_names.size());
      for (const double time : {0.0, 0.31, 0.5, 1.0}) {
        EXPECT_LT(worst_angle(t_pose, kMixamo, clip, to, words, carried, time), 2e-4) << time;
      }
      ASSERT_EQ(warnings.size(), 1u);
      EXPECT_HAS(warnings[0], "16 of 16 bodies");
      EXPECT_EQ(warnings[0].find("45 deg") != std::string::npos, drop > 0.0) << warnings[0];
    }
  }
}

// Z up and looking along -x; the character stands in its own axes.
TEST(Retarget, AxesOfTheMotionAreItsOwn) {
  const Mat3 axes =
      rotation_about(Vec3::UnitZ(), -90 * kDegree) * rotation_about(Vec3::UnitX(), 90 * kDegree);
  const Character from = person(kPoser, 0.0, 100.0, axes), to = person(kVrm, 0.5);
  const BodyClip clip = wave(from, kPoser);
  std::vector<std::string> warnings;
  const BodyClip carried = retarget(from, clip, to, {}, "x", warnings);
  for (const double time : {0.0, 0.4, 1.0}) {
    EXPECT_LT(worst_angle(from, kPoser, clip, to, kVrm, carried, time, axes), 2e-4) << time;
  }
}

// Keys one second apart: between them a hand moves along the same arc as that of the motion.
TEST(Retarget, FewKeysAreResampled) {
  const Character from = person(kMixamo, 0.0), to = person(kPoser, 0.0);
  BodyClip clip = wave(from, kMixamo);
  for (BodyTrack& track : clip.tracks) {
    auto& curve = track.rotation;
    curve.times = {0.0, 1.0};
    curve.values = {curve.values.front(), curve.values.back()};
  }
  std::vector<std::string> warnings;
  const BodyClip carried = retarget(from, clip, to, {}, "x", warnings);
  EXPECT_EQ(carried.tracks[0].rotation.times.size(), 61u);
  EXPECT_LT(worst_angle(from, kMixamo, clip, to, kPoser, carried, 0.5), 2e-4);
}

// Adds toes, which tell left from right when all names are removed.
Character with_toes(Character person, bool names) {
  const double size = (person.bind[1].translation() - person.bind[0].translation()).norm() / 0.3;
  for (const bool left : {true, false}) {
    const int foot = body_of(person, kMixamo.foot, left);
    Affine world = person.bind[foot];
    world.translate(Vec3(0, -0.05 * size, 0.15 * size));
    person.skeleton.body_names.push_back(named("mixamorig:%ToeBase", left));
    person.skeleton.parent.push_back(foot);
    person.bind.push_back(world);
    person.rest.push_back(person.bind[foot].inverse() * world);
    person.skeleton.joint_in_parent.push_back(Transform(person.rest.back().matrix()));
    person.skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
    person.skeleton.joint_axes.push_back(Vec3::UnitX());
  }
  for (int i = 0; !names && i < person.skeleton.size(); ++i) {
    person.skeleton.body_names[i] = "nodes[" + std::to_string(i) + "]";
  }
  return person;
}

// Ground truth is the same motion between the same skeletons with names.
TEST(Retarget, WithoutNamesShapeTells) {
  const Mat3 looks_back =
      rotation_about(Vec3::UnitZ(), -90 * kDegree) * rotation_about(Vec3::UnitX(), 90 * kDegree);
  const Character theirs = person(kMixamo, 0.0, 100.0, looks_back);
  const Character ours = person(kMixamo, 0.6, 0.6, rotation_about(Vec3::UnitY(), kPi));
  const BodyClip clip = wave(theirs, kMixamo);
  std::vector<std::string> warnings;
  const BodyClip truth =
      retarget(with_toes(theirs, true), clip, with_toes(ours, true), {}, "x", warnings);
  for (const bool from_named : {true, false}) {
    const Character to = with_toes(ours, false);
    Character from = with_toes(theirs, from_named);
    for (std::string& name : from.skeleton.body_names) {
      if (!from_named) name = "joint" + name.substr(5);  // equal names would tell as well
    }
    warnings.clear();
    const BodyClip carried = retarget(from, clip, to, {}, "x", warnings);
    ASSERT_EQ(carried.tracks.size(), truth.tracks.size());
    for (int b = 0; b < ours.skeleton.size(); ++b) {  // toes are told by names alone
      const auto &a = truth.tracks[b].rotation, &c = carried.tracks[b].rotation;
      ASSERT_EQ(a.times, c.times);
      for (size_t k = 0; k < a.times.size(); ++k) {
        ASSERT_LT(a.values[k].angularDistance(c.values[k]), 1e-7) << b << " " << k;
      }
    }
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_HAS(warnings[0], "of the rig by shape: ");
    EXPECT_HAS(warnings[0], "left arm \"nodes[2]\" \"nodes[3]\" \"nodes[4]\" \"nodes[5]\"");
    EXPECT_HAS(warnings[0], "by the feet");
    EXPECT_EQ(warnings[0].find("of the motion by shape") == std::string::npos, from_named);
  }
}

class MotionFiles : public TempFolder {};

TEST_F(MotionFiles, NeedNoMesh) {
  const std::string gltf =
      R"({"asset":{"version":"2.0"},"nodes":[{"name":"LeftArm","children":[1]},{"name":"LeftForeArm"}]})";
  EXPECT_EQ(import_motion(write("a.glb.gltf", gltf)).skeleton.size(), 2);
  EXPECT_HAS(input_error([&] { import_character(write("b.gltf", gltf)); }), "has no mesh");
  const std::string what = input_error([&] { import_motion(write("arm26.osim", "<x/>")); });
  EXPECT_HAS(what, "muscles Thew does not read");
  EXPECT_HAS(what, ".mot");
}

}  // namespace
}  // namespace thew::tests
