// SPDX-License-Identifier: Apache-2.0
#include "rig/character_bones.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numeric>

namespace thew::rig {
namespace {

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_small(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

// The bodies of MikuMikuDance's models, as their makers name them: "左ひじ" -> "left elbow".
std::string in_english(std::string name) {
  constexpr std::pair<const char*, const char*> kWords[] = {
      {"左", "left"}, {"右", "right"},     {"手首", "wrist"}, {"足首", "ankle"}, {"つま先", "toe"},
      {"先", "nub"},  {"捩", "twist"},     {"ＩＫ", "ik"},    {"指", "finger"},  {"肩", "shoulder"},
      {"腕", "arm"},  {"ひじ", "elbow"},   {"足", "upleg"},   {"ひざ", "knee"},  {"頭", "head"},
      {"首", "neck"}, {"上半身", "spine"}, {"下半身", "hips"}};
  for (const auto& [word, english] : kWords) {
    for (size_t at; (at = name.find(word)) != std::string::npos;) {
      name.replace(at, std::char_traits<char>::length(word), std::string(" ") + english + " ");
    }
  }
  return name;
}

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

// The side that the words tell, 0 for none. All other words are appended to `others`.
int take_side(const std::vector<std::string>& words, std::string& others) {
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
    others += word;
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

// Of several bodies above the forearm with an upper arm's name, such as "ToArm" and "Arm" or the
// two halves of one that twists, the one whose length is nearest to a person's, of those that begin
// beside the trunk.
int usual_humerus(const Character& character, int humerus, int forearm, int hand) {
  const Skeleton& skeleton = character.skeleton;
  const BoneName own = read_bone_name(skeleton.body_names[humerus]);
  const double usual =
      kUpperOverFore * (position_of(character, hand) - position_of(character, forearm)).norm();
  double least = std::numeric_limits<double>::infinity();
  for (int i = skeleton.parent[forearm]; i >= 0; i = skeleton.parent[i]) {
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    if (name.kind != BoneKind::kHumerus || name.side != own.side) continue;
    const double length = (position_of(character, i) - position_of(character, forearm)).norm();
    const double off = std::max(length / usual, usual / length);
    if (begins_beside(character, i, forearm) && off < least) least = off, humerus = i;
  }
  return humerus;
}

// Poser and CMU name the arm's bones collar, shoulder, elbow and wrist: there "shoulder" is the
// humerus, which read_bone_name() takes for a clavicle.
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

// Where several bodies have the name of this bone, takes the nearest ancestor of the limb.
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

bool is_pivot(const std::string& name) { return name.find("_$AssimpFbx$_") != std::string::npos; }

BoneName read_bone_name(const std::string& name) {
  if (is_pivot(name)) return {};
  const std::vector<std::string> words = words_of(in_english(name));
  std::string all;
  const int side = take_side(words, all);
  BoneKind kind = kind_of(words, all);
  if (kind == BoneKind::kHips && side != 0) kind = BoneKind::kThigh;  // "LeftHip", of Poser
  if (all.find("pelvis") != std::string::npos && side != 0) kind = BoneKind::kNone;
  return {kind, side};
}

int side_by_names(const Skeleton& skeleton, const std::vector<int>& limb,
                  const std::vector<int>& other) {
  const auto of = [&](const std::vector<int>& bodies) {
    int sum = 0;
    for (const int body : bodies) {
      if (body >= 0) sum += read_bone_name(skeleton.body_names[body]).side;
    }
    return (sum > 0) - (sum < 0);
  };
  return of(limb) == -of(other) ? of(limb) : 0;
}

HumanBodies human_bodies(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  HumanBodies bodies;
  for (const Character::HumanBone& bone : character.humanoid) {
    const BoneName name = read_bone_name(bone.bone);
    if (name.kind != BoneKind::kNone) bodies.emplace(std::pair(name.kind, name.side), bone.body);
  }
  const HumanBodies of_file = bodies;
  std::vector<int> order(skeleton.size());  // bodies with skin first: others may control them
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(),
                        [has_skin = bodies_with_skin(character)](int i) { return has_skin[i]; });
  for (const int i : order) {
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    const bool of_trunk = name.kind == BoneKind::kNeck || name.kind == BoneKind::kHead;
    if (name.kind == BoneKind::kNone || name.kind == BoneKind::kHips ||
        name.kind == BoneKind::kSpine || of_trunk != (name.side == 0)) {
      continue;  // a limb needs a side, the trunk must not have one
    }
    bodies.emplace(std::pair(name.kind, name.side), i);  // the first body of a name counts
  }
  for (const int side : {-1, 1}) {
    add_shoulders(character, side, bodies);
    const auto of = [&](BoneKind kind) {
      const auto found = bodies.find({kind, side});
      return found == bodies.end() ? -1 : found->second;
    };
    const int humerus = of(BoneKind::kHumerus), forearm = of(BoneKind::kForearm);
    if (const int hand = of(BoneKind::kHand); humerus >= 0 && forearm >= 0 && hand >= 0) {
      bodies[{BoneKind::kHumerus, side}] = whole_humerus(character, humerus, forearm, hand);
    }
    if (bodies.count({BoneKind::kThigh, side}) == 0 && bodies.count({BoneKind::kShin, side}) > 0) {
      bodies[{BoneKind::kThigh, side}] = bodies[{BoneKind::kShin, side}];  // "Leg", of one piece
      bodies.erase({BoneKind::kShin, side});
    }
    if (of_file.count({BoneKind::kClavicle, side}) > 0) continue;
    set_nearest(character, BoneKind::kClavicle, BoneKind::kHumerus, side, bodies);
  }
  add_trunk(skeleton, bodies);
  return bodies;
}

bool begins_beside(const Character& character, int humerus, int end) {
  const Skeleton& skeleton = character.skeleton;
  const auto depth = [&](int body) {
    int bodies = 0;
    while ((body = skeleton.parent[body]) >= 0) ++bodies;
    return bodies;
  };
  const Vec3 begin = position_of(character, humerus);
  const double least = kShouldersApart * (position_of(character, end) - begin).norm();
  const BoneName own = read_bone_name(skeleton.body_names[humerus]);
  for (int i = 0; i < skeleton.size(); ++i) {
    const BoneName name = read_bone_name(skeleton.body_names[i]);
    const bool is_other = own.side != 0 && name.kind == own.kind && name.side == -own.side;
    if (is_other && depth(i) == depth(humerus) &&
        (position_of(character, i) - begin).norm() < least)
      return false;
  }
  return true;
}

int whole_humerus(const Character& character, int humerus, int forearm, int hand) {
  constexpr double kShort = 0.9;       // of the forearm: a person's upper arm is longer than that
  constexpr double kStraight = 0.966;  // cosine of 15 degrees
  const Skeleton& skeleton = character.skeleton;
  const auto above = [&](int body) {
    do body = skeleton.parent[body];
    while (body >= 0 && is_pivot(skeleton.body_names[body]));
    return body;
  };
  const auto is_shoulder = [&](int body) {
    return body >= 0 && read_bone_name(skeleton.body_names[body]).kind == BoneKind::kClavicle;
  };
  humerus = usual_humerus(character, humerus, forearm, hand);
  const int first = above(humerus);
  if (!is_shoulder(first) || !is_shoulder(above(first))) return humerus;
  const Vec3 elbow = position_of(character, forearm);
  const Vec3 second = elbow - position_of(character, humerus);
  const Vec3 before = position_of(character, humerus) - position_of(character, first);
  const double fore = (position_of(character, hand) - elbow).norm();
  const bool straight = second.dot(before) > kStraight * second.norm() * before.norm();
  return straight && second.norm() < kShort * fore ? first : humerus;
}

bool hangs_on(const Skeleton& skeleton, int body, int ancestor) {
  while (body > ancestor) body = skeleton.parent[body];
  return body == ancestor;
}

}  // namespace thew::rig
