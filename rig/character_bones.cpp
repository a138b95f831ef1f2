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

// Adds chest, hips and spine: the common ancestors of both arms and of arms and legs.
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

// m, for each body the longest path down the tree from it.
std::vector<double> reaches(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  std::vector<double> reach(skeleton.size(), 0.0);
  for (int i = skeleton.size() - 1; i > 0; --i) {
    const int on = skeleton.parent[i];
    if (on < 0) continue;
    const double length = (position_of(character, i) - position_of(character, on)).norm();
    reach[on] = std::max(reach[on], reach[i] + length);
  }
  return reach;
}

// Bodies of a limb: girdle (clavicle), upper bone, lower bone, end (hand, foot) and the first body
// of what is attached to the end; -1 for none.
struct Limb {
  int girdle = -1, upper = -1, lower = -1, end = -1, tip = -1;
  double length = 0.0;  // m, of upper and lower bone; 0: no limb
};

// The limb along the longest path down from a body. Of bodies that lie at one position the last is
// taken, because it has the rotations of all.
Limb limb_from(const Character& character, const std::vector<double>& reach, int body) {
  constexpr double kOneJoint = 0.02;  // share of the reach within which bodies are one joint
  const Skeleton& skeleton = character.skeleton;
  std::vector<int> chain = {body};
  for (int now = body; now >= 0;) {
    int next = -1;
    double most = 0.0;
    for (int i = now + 1; i < skeleton.size(); ++i) {
      if (skeleton.parent[i] != now) continue;
      const double longest =
          reach[i] + (position_of(character, i) - position_of(character, now)).norm();
      if (longest > most) most = longest, next = i;
    }
    if (next >= 0) {
      const Vec3 step = position_of(character, next) - position_of(character, chain.back());
      if (step.norm() > kOneJoint * reach[body]) {
        chain.push_back(next);
      } else {
        chain.back() = next;
      }
    }
    now = next;
  }
  Limb limb;
  for (size_t k = 0; k + 2 < chain.size() && k < 2; ++k) {  // at most one girdle
    double parts[2];
    for (int j = 0; j < 2; ++j) {
      parts[j] =
          (position_of(character, chain[k + j + 1]) - position_of(character, chain[k + j])).norm();
    }
    if (parts[0] + parts[1] <= limb.length || parts[1] < 0.3 * parts[0]) continue;
    limb = {k > 0 ? chain[k - 1] : -1,
            chain[k],
            chain[k + 1],
            chain[k + 2],
            k + 3 < chain.size() ? chain[k + 3] : -1,
            parts[0] + parts[1]};
  }
  return limb;
}

struct LimbPair {
  int trunk = -1;
  Limb sides[2];
};

// Pairs of limbs of nearly equal length that are attached to one trunk, longest first.
std::vector<LimbPair> limb_pairs(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  const std::vector<double> reach = reaches(character);
  std::vector<LimbPair> pairs;
  for (int a = 0; a < skeleton.size(); ++a) {
    if (reach[a] <= 0.0) continue;
    for (int b = a + 1; b < skeleton.size(); ++b) {
      if (skeleton.parent[a] < 0 || skeleton.parent[a] != skeleton.parent[b]) continue;
      if (std::abs(reach[a] - reach[b]) > 0.1 * reach[a]) continue;
      const LimbPair pair{skeleton.parent[a],
                          {limb_from(character, reach, a), limb_from(character, reach, b)}};
      const double length = pair.sides[0].length, other = pair.sides[1].length;
      if (length > 0.0 && std::abs(length - other) < 0.1 * length) pairs.push_back(pair);
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const LimbPair& a, const LimbPair& b) {
    return a.sides[0].length > b.sides[0].length;
  });
  return pairs;
}

// The two longest pairs of which one is attached to a descendant of the other's trunk: that one has
// the arms.
bool arms_and_legs(const Character& character, LimbPair& arms, LimbPair& legs) {
  const std::vector<LimbPair> pairs = limb_pairs(character);
  for (size_t k = 1; k < pairs.size(); ++k) {
    for (size_t j = 0; j < k; ++j) {
      const int a = pairs[j].trunk, b = pairs[k].trunk;
      // Farther down the tree, since parents come first.
      const LimbPair& lower = a > b ? pairs[j] : pairs[k];
      const LimbPair& upper = a > b ? pairs[k] : pairs[j];
      if (a == b || !hangs_on(character.skeleton, lower.trunk, upper.trunk)) continue;
      const Limb& of = upper.sides[0];  // a pair of toes or fingers is no limb
      const int trunk = lower.trunk;
      if (hangs_on(character.skeleton, trunk, of.upper)) continue;
      if (hangs_on(character.skeleton, trunk, upper.sides[1].upper)) continue;
      arms = lower, legs = upper;
      return true;
    }
  }
  return false;
}

// Direction to the person's left. `feet` tells whether the toes gave it; without toes the person is
// taken to face along z, as in glTF.
Vec3 left_of(const Character& character, const LimbPair& arms, const LimbPair& legs, bool& feet) {
  const auto middle = [&](const LimbPair& pair) {
    return Vec3(0.5 * (position_of(character, pair.sides[0].upper) +
                       position_of(character, pair.sides[1].upper)));
  };
  const Vec3 up = (middle(arms) - middle(legs)).normalized();
  Vec3 forward = Vec3::Zero();
  double length = 0.0;
  for (const Limb& leg : legs.sides) {
    if (leg.tip < 0) continue;
    const Vec3 foot = position_of(character, leg.tip) - position_of(character, leg.end);
    forward += foot - foot.dot(up) * up;
    length += foot.norm();
  }
  feet = forward.norm() > 0.1 * length;
  if (!feet) forward = Vec3::UnitZ();
  return up.cross(forward);
}

}  // namespace

std::string add_limbs_by_geometry(const Character& character, HumanBodies& bodies) {
  const auto named = [&](BoneKind kind) {
    return bodies.count({kind, 1}) + bodies.count({kind, -1}) > 0;
  };
  const bool no_arms = !named(BoneKind::kHumerus) && !named(BoneKind::kForearm);
  const bool no_legs = !named(BoneKind::kThigh) && !named(BoneKind::kShin);
  LimbPair arms, legs;
  if ((!no_arms && !no_legs) || !arms_and_legs(character, arms, legs)) return "";
  bool feet = false;
  const Vec3 left = left_of(character, arms, legs, feet);
  std::string summary;
  const auto put = [&](const LimbPair& pair, std::initializer_list<BoneKind> kinds,
                       const char* what) {
    const Vec3 across =
        position_of(character, pair.sides[0].upper) - position_of(character, pair.sides[1].upper);
    for (int k = 0; k < 2; ++k) {
      const Limb& limb = pair.sides[k];
      const int side = (across.dot(left) > 0.0) == (k == 0) ? 1 : -1;
      const int of[] = {limb.girdle, limb.upper, limb.lower, limb.end};
      summary += std::string(summary.empty() ? "" : "; ") + (side > 0 ? "left " : "right ") + what;
      size_t j = 0;
      for (const BoneKind kind : kinds) {
        const int body = of[j++];
        if (body < 0 || kind == BoneKind::kNone) continue;
        bodies.emplace(std::pair(kind, side), body);
        summary += " \"" + character.skeleton.body_names[body] + "\"";
      }
    }
  };
  if (no_arms) {
    put(arms, {BoneKind::kClavicle, BoneKind::kHumerus, BoneKind::kForearm, BoneKind::kHand},
        "arm");
  }
  if (no_legs) {
    put(legs, {BoneKind::kNone, BoneKind::kThigh, BoneKind::kShin, BoneKind::kFoot}, "leg");
  }
  add_trunk(character.skeleton, bodies);
  return summary + (feet ? ", left and right by the feet" : ", taken to look along z");
}

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
