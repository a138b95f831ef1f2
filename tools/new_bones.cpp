// SPDX-License-Identifier: Apache-2.0
//
// Which bodies of a character are its arms.
#include <algorithm>
#include <cctype>

#include "rig/text.h"
#include "tools/new_arm.h"

namespace thew {
namespace {

enum class Part { kNone, kClavicle, kHumerus, kForearm, kHand };

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }
bool is_small(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

// "mixamorig:LeftForeArm" -> "mixamorig", "left", "fore", "arm"
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
    if (!is_small(c) && i > 0 && is_small(name[i - 1])) end();
    word.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  }
  end();
  return words;
}

// -1 right, 1 left, 0 neither.
int side_of(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "l" || word.starts_with("left")) return 1;
    if (word == "r" || word.starts_with("right")) return -1;
  }
  return 0;
}

Part part_of(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += word;
  // Blender's Collada puts the armature's name before each bone's.
  for (size_t at; (at = all.find("armature")) != std::string::npos;) all.erase(at, 8);
  const auto has = [&](std::initializer_list<const char*> parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return all.find(part) != std::string::npos; });
  };
  if (has({"twist", "roll", "target", "pole", "thumb", "finger", "index", "middle", "ring", "pinky",
           "assimpfbx"})) {
    return Part::kNone;
  }
  if (words.end() != std::find(words.begin(), words.end(), "ik")) return Part::kNone;
  if (has({"clavicle", "collar", "scapula", "shoulder"})) return Part::kClavicle;
  if (has({"forearm", "lowerarm", "lowarm", "loarm", "armlower", "elbow", "ulna", "radius"})) {
    return Part::kForearm;
  }
  if (has({"hand", "wrist", "palm"})) return Part::kHand;
  return has({"arm", "humerus", "shldr"}) ? Part::kHumerus : Part::kNone;  // Daz: rShldrBend
}

Vec3 place_of(const Character& character, int body) { return character.bind[body].translation(); }

int first_child(const Skeleton& skeleton, int body) {
  for (int i = body + 1; i < skeleton.size(); ++i) {
    if (skeleton.parent[i] == body) return i;
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
    throw Error(ExitCode::kUsage, "--map " + found->first + "=" + found->second +
                                      ": is no body of " + place +
                                      did_you_mean(found->second, character.skeleton.body_names) +
                                      "; `thew inspect " + place + "` lists them");
  }
  return -1;
}

// The first body of a part on a side whose place in the tree fits; the skin hangs on it.
void by_name(const Character& character, ArmBodies& arm) {
  const Skeleton& skeleton = character.skeleton;
  std::vector<char> of_skin(skeleton.size(), 0);
  for (const SkinWeights::Link& link : character.skin.links) of_skin[link.body] = 1;
  const auto seek = [&](Part part, int on) {
    for (int i = 0; i < skeleton.size(); ++i) {
      if (!of_skin[i]) continue;
      const auto words = words_of(skeleton.body_names[i]);
      if (part_of(words) != part || side_of(words) != (arm.left ? 1 : -1)) continue;
      if (on < 0 || (i != on && hangs_on(skeleton, i, on))) return i;
    }
    return -1;
  };
  if (arm.humerus < 0) arm.humerus = seek(Part::kHumerus, -1);
  if (arm.humerus < 0) return;
  if (arm.forearm < 0) arm.forearm = seek(Part::kForearm, arm.humerus);
  if (arm.forearm >= 0 && arm.hand < 0) arm.hand = seek(Part::kHand, arm.forearm);
}

// Upper arm, forearm, hand, begun at a body that hangs on a trunk.
struct Chain {
  int bodies[3];
  double lengths[2];
};

bool chain_from(const Character& character, int body, Chain& chain) {
  const Skeleton& skeleton = character.skeleton;
  int now[4];
  double lengths[3];
  for (int k = 0; k < 4; ++k) {
    now[k] = k == 0 ? body : first_child(skeleton, now[k - 1]);
    if (now[k] < 0 && k < 3) return false;
    if (k == 0 || now[k] < 0) continue;
    lengths[k - 1] = (place_of(character, now[k]) - place_of(character, now[k - 1])).norm();
  }
  // A short first one is a clavicle.
  const int skip = now[3] >= 0 && lengths[0] < 0.5 * lengths[1] && lengths[2] > 0.5 * lengths[1];
  for (int k = 0; k < 3; ++k) chain.bodies[k] = now[k + skip];
  for (int k = 0; k < 2; ++k) chain.lengths[k] = lengths[k + skip];
  return chain.lengths[0] > 0.0 && chain.lengths[1] > 0.3 * chain.lengths[0];
}

// Two chains on one trunk, alike, side by side and in the upper half of the body.
void by_shape(const Character& character, bool left, ArmBodies& arm) {
  const Skeleton& skeleton = character.skeleton;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : character.mesh.vertices) box.extend(p);
  if (box.isEmpty()) return;
  for (int a = 0; a < skeleton.size(); ++a) {
    for (int b = a + 1; b < skeleton.size(); ++b) {
      if (skeleton.parent[a] < 0 || skeleton.parent[a] != skeleton.parent[b]) continue;
      Chain one, two;
      if (!chain_from(character, a, one) || !chain_from(character, b, two)) continue;
      const Vec3 p = place_of(character, one.bodies[0]), q = place_of(character, two.bodies[0]);
      const double size = one.lengths[0];
      const bool alike = std::abs(two.lengths[0] - size) < 0.1 * size &&
                         std::abs(two.lengths[1] - one.lengths[1]) < 0.1 * size;
      const Vec3 line(p.x() - q.x(), 0.0, p.z() - q.z());
      const bool beside = std::abs(p.y() - q.y()) < 0.2 * size && line.norm() > 0.1 * size;
      if (!alike || !beside || p.y() < box.center().y()) continue;
      Vec3 forward = facing_of(character, line);
      if (forward.isZero()) forward = Vec3::UnitZ();  // as glTF has it
      const bool first_is_left = line.dot(Vec3::UnitY().cross(forward)) > 0.0;
      const Chain& mine = first_is_left == left ? one : two;
      arm.humerus = mine.bodies[0];
      arm.forearm = mine.bodies[1];
      arm.hand = mine.bodies[2];
      return;
    }
  }
}

[[noreturn]] void refuse_doubt(const Character& character, const std::string& place,
                               const char* what, bool left) {
  const Skeleton& skeleton = character.skeleton;
  std::string list;
  for (int i = 0; i < skeleton.size(); ++i) {
    if (first_child(skeleton, i) < 0 || skeleton.parent[i] < 0) continue;
    list += (list.empty() ? " " : " | ") + skeleton.body_names[i] + " at " +
            point_text(place_of(character, i)) + ", on " + skeleton.body_names[skeleton.parent[i]];
  }
  throw Error(ExitCode::kUsage, place + ": which body is the " + (left ? "left " : "right ") +
                                    what + "? Neither names nor shape tell; say --map " +
                                    (left ? "left_" : "right_") + what +
                                    "=BODY (humerus, forearm, hand, clavicle). Candidates:" +
                                    (list.empty() ? " none, the file has no skeleton" : list));
}

}  // namespace

bool hangs_on(const Skeleton& skeleton, int body, int ancestor) {
  while (body > ancestor) body = skeleton.parent[body];
  return body == ancestor;
}

std::vector<ArmBodies> find_arms(const Character& character, const std::string& side,
                                 const BoneMap& map, const std::string& place,
                                 std::vector<std::string>& notes) {
  const std::vector<std::string> known = {"clavicle", "humerus", "forearm", "hand"};
  for (const auto& [key, body] : map) {
    std::string part = key;
    const bool sided = key.starts_with("left_") || key.starts_with("right_");
    if (sided ? key.starts_with(side == "left" ? "right_" : "left_") && side != "both"
              : side == "both") {
      throw Error(ExitCode::kUsage, "--map " + key + "=" + body + ": " +
                                        (sided ? "is not on the side asked for; give --side both"
                                               : "on which side? Give left_" + key + " or right_" +
                                                     key + ", or --side"));
    }
    for (const char* begin : {"left_", "right_"}) {
      if (part.starts_with(begin)) part = part.substr(std::string(begin).size());
    }
    if (std::find(known.begin(), known.end(), part) != known.end()) continue;
    throw Error(ExitCode::kUsage,
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
    by_name(character, arm);
    if (arm.humerus < 0) {
      by_shape(character, left, arm);
      if (arm.humerus >= 0) {
        notes.push_back(
            std::string(left ? "left" : "right") +
            " arm found by the skeleton's shape, left and right by the feet; if that is "
            "wrong, use --map");
      }
    }
    const Skeleton& skeleton = character.skeleton;
    if (arm.humerus < 0) refuse_doubt(character, place, "humerus", left);
    if (arm.forearm < 0) arm.forearm = first_child(skeleton, arm.humerus);
    if (arm.forearm < 0) refuse_doubt(character, place, "forearm", left);
    if (arm.hand < 0) arm.hand = first_child(skeleton, arm.forearm);
    if (arm.hand < 0) refuse_doubt(character, place, "hand", left);
    if (arm.clavicle < 0) arm.clavicle = skeleton.parent[arm.humerus];
    if (arm.clavicle < 0) refuse_doubt(character, place, "clavicle", left);
    if (!hangs_on(skeleton, arm.forearm, arm.humerus) ||
        !hangs_on(skeleton, arm.hand, arm.forearm)) {
      throw Error(ExitCode::kUsage,
                  place + ": \"" + skeleton.body_names[arm.hand] + "\" does not hang on \"" +
                      skeleton.body_names[arm.forearm] + "\" and that on \"" +
                      skeleton.body_names[arm.humerus] + "\"; name the arm's bodies with --map");
    }
    arms.push_back(arm);
  }
  return arms;
}

}  // namespace thew
