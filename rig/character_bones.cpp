// SPDX-License-Identifier: Apache-2.0
#include "rig/character_bones.h"

#include <algorithm>
#include <cctype>

namespace thew {
namespace {

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_small(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

// "mixamorig:LeftForeArm" -> "mixamorig", "left", "fore", "arm"; "RArm" -> "r", "arm"
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words;
  std::string word;
  const auto end = [&] {
    if (!word.empty()) words.push_back(word);
    word.clear();
  };
  for (size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (!is_letter(c)) {
      end();
      continue;
    }
    const bool after_small = i > 0 && is_small(name[i - 1]);
    const bool before_small = i + 1 < name.size() && is_small(name[i + 1]);
    if (!is_small(c) && (after_small || before_small)) end();
    word.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  }
  end();
  return words;
}

// The side, and all other words as one.
int take_side(const std::vector<std::string>& words, std::string& rest) {
  int side = 0;
  for (std::string word : words) {
    int here = word == "l" ? 1 : word == "r" ? -1 : 0;
    if (here != 0) word.clear();
    for (const auto& [begin, of] : {std::pair("left", 1), std::pair("right", -1)}) {
      if (!word.starts_with(begin)) continue;
      here = of;
      word.erase(0, std::string(begin).size());
    }
    if (side == 0) side = here;
    rest += word;
  }
  return side;
}

BoneKind kind_of(const std::vector<std::string>& words, std::string all) {
  // Blender's Collada puts the armature's name before each bone's.
  for (size_t at; (at = all.find("armature")) != std::string::npos;) all.erase(at, 8);
  const auto has = [&](std::initializer_list<const char*> parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return all.find(part) != std::string::npos; });
  };
  if (has({"twist", "roll", "target", "pole", "thumb", "finger", "index", "middle", "ring", "pinky",
           "little", "assimpfbx", "nub", "rigmesh", "armor", "armour", "socket", "hipjoint"})) {
    return BoneKind::kNone;
  }
  if (words.end() != std::find(words.begin(), words.end(), "ik")) return BoneKind::kNone;
  if (has({"clavicle", "collar", "scapula", "shoulder"})) return BoneKind::kClavicle;
  if (has({"forearm", "lowerarm", "lowarm", "loarm", "armlower", "elbow", "ulna", "radius"})) {
    return BoneKind::kForearm;
  }
  if (has({"toe", "foottip"}) || words.end() != std::find(words.begin(), words.end(), "ball")) {
    return BoneKind::kToes;
  }
  if (has({"foot", "ankle"})) return BoneKind::kFoot;
  if (has({"upperleg", "upleg", "legupper", "thigh", "femur"})) return BoneKind::kThigh;
  if (has({"leg", "calf", "shin", "knee", "tibia"})) return BoneKind::kShin;
  if (has({"hand", "wrist", "palm"})) return BoneKind::kHand;
  if (has({"arm", "humerus", "shldr"})) return BoneKind::kHumerus;  // Daz: rShldrBend
  if (has({"head"})) return BoneKind::kHead;
  if (has({"neck"})) return BoneKind::kNeck;
  if (has({"hip", "pelvis"})) return BoneKind::kHips;
  return has({"spine", "chest", "torso"}) ? BoneKind::kSpine : BoneKind::kNone;
}

int common_ancestor(const Skeleton& skeleton, int a, int b) {
  while (a != b) (a > b ? a : b) = skeleton.parent[std::max(a, b)];  // parents come first
  return a;
}

// The trunk, by where the limbs hang on it.
void add_trunk(const Skeleton& skeleton, HumanBodies& bodies) {
  const auto ancestor = [&](BoneKind kind) {
    const auto left = bodies.find({kind, 1}), right = bodies.find({kind, -1});
    if (left == bodies.end() || right == bodies.end()) return -1;
    return common_ancestor(skeleton, left->second, right->second);
  };
  const int chest = ancestor(BoneKind::kHumerus), legs = ancestor(BoneKind::kThigh);
  if (chest < 0) return;
  bodies.emplace(std::pair(BoneKind::kChest, 0), chest);
  if (legs < 0) return;
  const int hips = common_ancestor(skeleton, chest, legs);
  if (hips < 0 || hips == chest) return;
  bodies.emplace(std::pair(BoneKind::kHips, 0), hips);
  int spine = chest;
  while (skeleton.parent[spine] != hips) spine = skeleton.parent[spine];
  if (spine != chest) bodies.emplace(std::pair(BoneKind::kSpine, 0), spine);
}

// Poser's and CMU's other words: collar, shoulder, elbow, wrist. There, the shoulder is the arm.
void add_shoulders(const Character& character, int side, HumanBodies& bodies) {
  const auto forearm = bodies.find({BoneKind::kForearm, side});
  if (bodies.count({BoneKind::kHumerus, side}) > 0 || forearm == bodies.end()) return;
  const Skeleton& skeleton = character.skeleton;
  for (int i = skeleton.parent[forearm->second]; i >= 0; i = skeleton.parent[i]) {
    if (is_pivot(skeleton.body_names[i])) continue;
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    if (name.kind == BoneKind::kClavicle && name.side == side) {
      bodies[{BoneKind::kHumerus, side}] = i;
    }
    return;
  }
}

// Of several that are called so, the one that the limb hangs on.
void set_nearest(const Character& character, BoneKind kind, BoneKind limb, int side,
                 HumanBodies& bodies) {
  const auto of = bodies.find({limb, side});
  if (of == bodies.end()) return;
  const Skeleton& skeleton = character.skeleton;
  bodies.erase({kind, side});
  for (int i = skeleton.parent[of->second]; i >= 0; i = skeleton.parent[i]) {
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    if (name.kind != kind || name.side != side) continue;
    bodies[{kind, side}] = i;
    return;
  }
}

}  // namespace

bool is_pivot(const std::string& name) { return name.find("_$AssimpFbx$_") != std::string::npos; }

BoneName read_bone_name(const std::string& name) {
  if (is_pivot(name)) return {};
  const std::vector<std::string> words = words_of(name);
  std::string all;
  const int side = take_side(words, all);
  BoneKind kind = kind_of(words, all);
  if (kind == BoneKind::kHips && side != 0) kind = BoneKind::kThigh;  // "LeftHip", of Poser
  if (all.find("pelvis") != std::string::npos && side != 0) kind = BoneKind::kNone;
  return {kind, side};
}

HumanBodies human_bodies(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  HumanBodies bodies;
  for (const Character::HumanBone& bone : character.humanoid) {
    const BoneName name = read_bone_name(bone.bone);
    if (name.kind != BoneKind::kNone) bodies.emplace(std::pair(name.kind, name.side), bone.body);
  }
  const HumanBodies told = bodies;
  for (int i = 0; i < skeleton.size(); ++i) {
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    const bool of_trunk = name.kind == BoneKind::kNeck || name.kind == BoneKind::kHead;
    if (name.kind == BoneKind::kNone || name.kind == BoneKind::kHips ||
        name.kind == BoneKind::kSpine || of_trunk != (name.side == 0)) {
      continue;  // a limb without a side is nobody's
    }
    bodies.emplace(std::pair(name.kind, name.side), i);  // the first has the word
  }
  for (const int side : {-1, 1}) {
    add_shoulders(character, side, bodies);
    if (bodies.count({BoneKind::kThigh, side}) == 0 && bodies.count({BoneKind::kShin, side}) > 0) {
      bodies[{BoneKind::kThigh, side}] = bodies[{BoneKind::kShin, side}];  // "Leg", of one piece
      bodies.erase({BoneKind::kShin, side});
    }
    if (told.count({BoneKind::kClavicle, side}) > 0) continue;
    set_nearest(character, BoneKind::kClavicle, BoneKind::kHumerus, side, bodies);
  }
  add_trunk(skeleton, bodies);
  return bodies;
}

bool hangs_on(const Skeleton& skeleton, int body, int ancestor) {
  while (body > ancestor) body = skeleton.parent[body];
  return body == ancestor;
}

}  // namespace thew
