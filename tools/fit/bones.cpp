// SPDX-License-Identifier: Apache-2.0
//
// Which bodies of a character are its arms.
#include <algorithm>
#include <cmath>

#include "rig/character_bones.h"
#include "rig/text.h"
#include "tools/fit/arm.h"

namespace thew::tools {
namespace {

// Past what FBX's reader puts between two bodies.
int first_child(const Skeleton& skeleton, int body) {
  for (int i = body + 1; i < skeleton.size(); ++i) {
    if (skeleton.parent[i] != body) continue;
    return is_pivot(skeleton.body_names[i]) ? first_child(skeleton, i) : i;
  }
  return -1;
}

int by_map(const Character& character, const BoneMap& map, const std::string& place, bool left,
           bool both, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    auto found = map.find(std::string(left ? "left_" : "right_") + key);
    if (found == map.end() && !both) found = map.find(key);
    if (found == map.end()) continue;
    const int body = find_body(character.skeleton, found->second);
    if (body >= 0) return body;
    throw Error(ErrorCode::kUsage, "--map " + found->first + "=" + found->second +
                                       ": is no body of " + place +
                                       did_you_mean(found->second, character.skeleton.body_names) +
                                       "; `thew inspect " + place + "` lists them");
  }
  return -1;
}

// The first body of a kind on a side whose place in the tree fits: one that carries skin, since the
// bones that control a rig have the same names (Rigify), else one that may carry some. VRM's own
// map has the first word. `side`: 1 left, -1 right, 0 where names tell none.
void by_name(const Character& character, int side, ArmBodies& arm) {
  const Skeleton& skeleton = character.skeleton;
  const std::vector<char> has_skin = bodies_with_skin(character);
  std::vector<char> of_skin(skeleton.size(), 0);
  for (const SkinWeights::Link& link : character.skin.links) of_skin[link.body] = 1;
  const auto fits = [&](const BoneName& name, BoneKind kind, int body, int on) {
    return name.kind == kind && name.side == side &&
           (on < 0 || (body != on && hangs_on(skeleton, body, on)));
  };
  const auto seek = [&](BoneKind kind, int on) {
    for (const Character::HumanBone& bone : character.humanoid) {
      if (fits(read_bone_name(bone.bone), kind, bone.body, on)) return bone.body;
    }
    const std::vector<char>* const in_turn[] = {&has_skin, &of_skin};
    for (const std::vector<char>* of : in_turn) {
      for (int i = 0; i < skeleton.size(); ++i) {
        if ((*of)[i] && fits(read_bone_name(skeleton.body_names[i]), kind, i, on)) return i;
      }
    }
    return -1;
  };
  const bool told = arm.humerus >= 0;
  if (!told) arm.humerus = seek(BoneKind::kHumerus, -1);
  for (int end; !told && arm.humerus >= 0 && (end = first_child(skeleton, arm.humerus)) >= 0;) {
    if (begins_beside(character, arm.humerus, end)) break;
    const BoneName name = read_bone_name(skeleton.body_names[end]);
    if (name.kind != BoneKind::kHumerus || name.side != side) break;
    const bool is_piece =  // of its skin
        seek(BoneKind::kForearm, end) < 0 && seek(BoneKind::kForearm, arm.humerus) >= 0;
    if (is_piece) break;
    arm.humerus = end;
  }
  if (arm.humerus < 0) {  // where the shoulder is the arm
    const HumanBodies bodies = human_bodies(character);
    const auto found = bodies.find({BoneKind::kHumerus, side});
    const bool known = found != bodies.end();
    if (known && (has_skin[found->second] || of_skin[found->second])) arm.humerus = found->second;
  }
  if (arm.humerus < 0) return;
  if (arm.forearm < 0) arm.forearm = seek(BoneKind::kForearm, arm.humerus);
  if (arm.forearm >= 0 && arm.hand < 0) arm.hand = seek(BoneKind::kHand, arm.forearm);
  if (arm.hand >= 0 && !told) {
    arm.humerus = whole_humerus(character, arm.humerus, arm.forearm, arm.hand);
  }
}

// The limbs that the skeleton's geometry tells; left and right by their names, else by the skin's
// feet, where it has some.
void by_shape(const Character& character, bool left, ArmBodies& arm) {
  HumanBodies bodies;
  add_limbs_by_geometry(character, bodies);
  if (bodies.count({BoneKind::kHumerus, 1}) == 0) return;
  const auto place = [&](int side) {
    return position_of(character, bodies.at({BoneKind::kHumerus, side}));
  };
  const auto of = [&](int side) {
    return std::vector<int>{bodies.at({BoneKind::kHumerus, side}),
                            bodies.at({BoneKind::kForearm, side}),
                            bodies.at({BoneKind::kHand, side})};
  };
  bool turned = false;
  if (side_by_names(character.skeleton, of(1), of(-1)) == 0) {
    const Vec3 line = place(1) - place(-1);
    const Vec3 forward = facing_of(character, line);
    turned = line.dot(Vec3::UnitY().cross(forward)) < 0.0;
  }
  const int side = left != turned ? 1 : -1;
  arm.humerus = bodies.at({BoneKind::kHumerus, side});
  arm.forearm = bodies.at({BoneKind::kForearm, side});
  arm.hand = bodies.at({BoneKind::kHand, side});
}

// The first body below the forearm that is no part of it, such as a half of it that twists: names
// call that a forearm too, and it lies well before a person's wrist.
int hand_below(const Character& character, const ArmBodies& arm) {
  constexpr double kBefore = 0.75;  // of a person's forearm
  const Skeleton& skeleton = character.skeleton;
  const Vec3 elbow = position_of(character, arm.forearm);
  const double fore = (elbow - position_of(character, arm.humerus)).norm() / kUpperOverFore;
  for (int i = arm.forearm + 1; i < skeleton.size(); ++i) {
    const std::string& name = skeleton.body_names[i];
    if (!hangs_on(skeleton, i, arm.forearm) || is_pivot(name)) continue;
    const bool is_part = read_bone_name(name).kind == BoneKind::kForearm &&
                         (position_of(character, i) - elbow).norm() < kBefore * fore;
    if (!is_part) return i;
  }
  return -1;
}

// Off the line along which it lies, the middle of what is about so far along: a line to the skin's
// mean may come out of a thin wrist beside it.
Vec3 middle_at(const std::vector<Vec3>& skin, const Vec3& along, double length) {
  constexpr double kAbout = 0.15;  // of the length
  const Vec3 a = along.unitOrthogonal(), b = along.cross(a);
  Eigen::AlignedBox2d box;
  for (const Vec3& p : skin) {
    if (std::abs(along.dot(p) - length) > kAbout * length) continue;
    box.extend(Eigen::Vector2d(a.dot(p), b.dot(p)));
  }
  if (box.isEmpty()) return Vec3::Zero();
  return box.center().x() * a + box.center().y() * b;
}

// The wrist of an arm that ends with the forearm's body: as far from the elbow as a person's, or
// where the skin that hangs on it ends. False where none does.
bool end_at_skin(const Character& character, ArmBodies& arm) {
  constexpr double kEnd = 0.95;  // of the skin's length
  constexpr double kMost = 0.5;  // of a vertex's weight
  const Skeleton& skeleton = character.skeleton;
  const SkinWeights& weights = character.skin;
  const Vec3 elbow = position_of(character, arm.forearm);
  std::vector<Vec3> skin;  // m, from the elbow
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < character.mesh.vertices.size(); ++i) {
    double share = 0.0;
    for (int k = weights.first[i]; k < weights.first[i + 1]; ++k) {
      const bool is_on = hangs_on(skeleton, weights.links[weights.link[k]].body, arm.forearm);
      share += is_on ? weights.weight[k] : 0.0;
    }
    if (share > kMost) skin.push_back(character.mesh.vertices[i] - elbow), sum += skin.back();
  }
  if (!(sum.norm() > 0.0)) return false;
  const Vec3 along = sum.normalized();
  double reach = 0.0;
  for (const Vec3& p : skin) reach = std::max(reach, along.dot(p));
  const double upper = (elbow - position_of(character, arm.humerus)).norm();
  const double length = std::min(kEnd * reach, upper / kUpperOverFore);
  arm.hand = arm.forearm;
  arm.wrist = character.bind[arm.forearm].inverse() *
              Vec3(elbow + length * along + middle_at(skin, along, length));
  return true;
}

[[noreturn]] void refuse_doubt(const Character& character, const std::string& place,
                               const char* what, bool left) {
  const Skeleton& skeleton = character.skeleton;
  std::string list;
  for (int i = 0; i < skeleton.size(); ++i) {
    if (first_child(skeleton, i) < 0 || skeleton.parent[i] < 0) continue;
    list += (list.empty() ? " " : " | ") + skeleton.body_names[i] + " at " +
            point_text(position_of(character, i)) + ", on " +
            skeleton.body_names[skeleton.parent[i]];
  }
  throw Error(ErrorCode::kUsage, place + ": which body is the " + (left ? "left " : "right ") +
                                     what + "? Neither names nor shape tell; say --map " +
                                     (left ? "left_" : "right_") + what +
                                     "=BODY (humerus, forearm, hand, clavicle). Candidates:" +
                                     (list.empty() ? " none, the file has no skeleton" : list));
}

}  // namespace

namespace {

// What the upper arm hangs on, or the clavicle that names tell where it hangs on none: bones that
// deform a rig are exported each on its own (Rigify).
int clavicle_of(const Character& character, const ArmBodies& arm) {
  const Skeleton& skeleton = character.skeleton;
  const auto is_clavicle = [&](int body) {
    const BoneName name = read_bone_name(skeleton.body_names[body]);
    return name.kind == BoneKind::kClavicle && name.side == (arm.left ? 1 : -1);
  };
  int above = skeleton.parent[arm.humerus];
  while (above >= 0 && is_pivot(skeleton.body_names[above])) above = skeleton.parent[above];
  if (above >= 0 && is_clavicle(above)) return above;
  const std::vector<char> has_skin = bodies_with_skin(character);
  const Vec3 shoulder = position_of(character, arm.humerus);
  const double length = (position_of(character, arm.forearm) - shoulder).norm();
  for (int i = 0; i < skeleton.size(); ++i) {
    const bool is_near = (position_of(character, i) - shoulder).norm() < length;
    if (has_skin[i] && is_near && is_clavicle(i) && !hangs_on(skeleton, i, arm.humerus)) return i;
  }
  return above;
}

// All but what was told, by names, else by shape; a note where it was the shape.
void complete_arm(const Character& character, bool one_side, const std::string& place,
                  ArmBodies& arm, std::vector<std::string>& notes) {
  const Skeleton& skeleton = character.skeleton;
  const std::vector<std::string>& names = skeleton.body_names;
  std::string guessed;
  const auto guess = [&](const char* what, int body) {
    guessed += (guessed.empty() ? "" : ", ") + std::string(what) + " " + names[body];
  };
  by_name(character, arm.left ? 1 : -1, arm);
  if (arm.humerus < 0 && one_side) by_name(character, 0, arm);  // its only arm, or either
  const ArmBodies named = arm;
  if (arm.humerus < 0) by_shape(character, arm.left, arm);
  if (arm.humerus < 0) refuse_doubt(character, place, "humerus", arm.left);
  if (arm.forearm < 0) arm.forearm = first_child(skeleton, arm.humerus);
  if (arm.forearm < 0) refuse_doubt(character, place, "forearm", arm.left);
  if (arm.hand < 0) arm.hand = hand_below(character, arm);
  if (arm.hand < 0 && !end_at_skin(character, arm)) {
    refuse_doubt(character, place, "hand", arm.left);
  }
  if (arm.clavicle < 0) arm.clavicle = clavicle_of(character, arm);
  if (arm.clavicle < 0) refuse_doubt(character, place, "clavicle", arm.left);
  if (named.humerus < 0) guess("humerus", arm.humerus);
  if (named.forearm < 0) guess("forearm", arm.forearm);
  if (named.hand < 0 && arm.has_hand()) guess("hand", arm.hand);
  if (!arm.has_hand()) {
    notes.push_back(std::string(arm.left ? "left" : "right") + " arm ends with the body " +
                    names[arm.forearm] + ": its wrist is taken to be " +
                    number_text(std::round(1e3 * arm.wrist.norm()) / 1e3) + " m from the elbow");
  }
  if (guessed.empty()) return;
  notes.push_back(std::string(arm.left ? "left" : "right") +
                  " arm by the skeleton's shape, where names do not tell: " + guessed +
                  (named.humerus < 0 ? "; left and right by the feet" : "") +
                  "; if that is wrong, use --map");
}

}  // namespace

std::vector<ArmBodies> find_arms(const Character& character, const std::string& side,
                                 const BoneMap& map, const std::string& place,
                                 std::vector<std::string>& notes) {
  const std::vector<std::string> known = {"clavicle", "humerus", "forearm", "hand"};
  for (const auto& [key, body] : map) {
    std::string part = key;
    const bool sided = key.starts_with("left_") || key.starts_with("right_");
    if (sided ? key.starts_with(side == "left" ? "right_" : "left_") && side != "both"
              : side == "both") {
      throw Error(ErrorCode::kUsage, "--map " + key + "=" + body + ": " +
                                         (sided ? "is not on the side asked for; give --side both"
                                                : "on which side? Give left_" + key + " or right_" +
                                                      key + ", or --side"));
    }
    for (const char* begin : {"left_", "right_"}) {
      if (part.starts_with(begin)) part = part.substr(std::string(begin).size());
    }
    if (std::find(known.begin(), known.end(), part) != known.end()) continue;
    throw Error(ErrorCode::kUsage,
                "--map " + key + "=" + body + ": is no part of an arm" + did_you_mean(part, known) +
                    "; give clavicle, humerus, forearm or hand, where needed with "
                    "left_ or right_ before it");
  }
  std::vector<ArmBodies> arms;
  for (const bool left : {false, true}) {
    if (side == (left ? "right" : "left")) continue;
    ArmBodies arm;
    arm.left = left;
    const auto told = [&](auto... keys) {
      return by_map(character, map, place, left, side == "both", {keys...});
    };
    arm.clavicle = told("clavicle");
    arm.humerus = told("humerus");
    arm.forearm = told("forearm");
    arm.hand = told("hand");
    complete_arm(character, side != "both", place, arm, notes);
    const Skeleton& skeleton = character.skeleton;
    if (!hangs_on(skeleton, arm.forearm, arm.humerus) ||
        !hangs_on(skeleton, arm.hand, arm.forearm)) {
      throw Error(ErrorCode::kUsage,
                  place + ": \"" + skeleton.body_names[arm.hand] + "\" does not hang on \"" +
                      skeleton.body_names[arm.forearm] + "\" and that on \"" +
                      skeleton.body_names[arm.humerus] + "\"; name the arm's bodies with --map");
    }
    arms.push_back(arm);
  }
  return arms;
}

double skin_left_behind(const Character& character, const ArmBodies& arm, int& most) {
  constexpr double kFrom = 0.3, kTo = 1.6;  // of the way from elbow to wrist
  constexpr double kAround = 0.2;           // of its length, from the line
  const Skeleton& skeleton = character.skeleton;
  const SkinWeights& weights = character.skin;
  const Vec3 elbow = position_of(character, arm.forearm);
  const Vec3 way = character.bind[arm.hand] * arm.wrist - elbow;
  double whole = 0.0, left = 0.0;
  std::vector<double> by_body(skeleton.size(), 0.0);
  for (const Triangle& t : character.mesh.triangles) {
    const Vec3 &a = character.mesh.vertices[t[0]], &b = character.mesh.vertices[t[1]];
    const Vec3& c = character.mesh.vertices[t[2]];
    const Vec3 from = (a + b + c) / 3.0 - elbow;
    const double at = from.dot(way) / way.squaredNorm();
    if (at < kFrom || at > kTo || (from - at * way).norm() > kAround * way.norm()) continue;
    const double area = 0.5 * (b - a).cross(c - a).norm();
    whole += area;
    for (const int corner : t) {
      for (int k = weights.first[corner]; k < weights.first[corner + 1]; ++k) {
        const int body = weights.links[weights.link[k]].body;
        if (hangs_on(skeleton, body, arm.humerus)) continue;
        left += area / 3.0 * weights.weight[k];
        by_body[body] += area / 3.0 * weights.weight[k];
      }
    }
  }
  most = static_cast<int>(std::max_element(by_body.begin(), by_body.end()) - by_body.begin());
  return whole > 0.0 ? left / whole : 0.0;
}

}  // namespace thew::tools
