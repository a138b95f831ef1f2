// SPDX-License-Identifier: Apache-2.0
//
// Arms and legs of a skeleton whose names tell none.
#include <algorithm>
#include <cmath>

#include "rig/character_bones.h"

namespace thew::rig {
namespace {

// The bodies below each, and the longest path down from it (m).
struct Tree {
  std::vector<std::vector<int>> below;
  std::vector<double> reach;

  explicit Tree(const Character& character)
      : below(character.skeleton.size()), reach(character.skeleton.size(), 0.0) {
    const std::vector<int>& parent = character.skeleton.parent;
    for (int i = 0; i < character.skeleton.size(); ++i) {
      if (parent[i] >= 0) below[parent[i]].push_back(i);
    }
    for (int i = character.skeleton.size() - 1; i > 0; --i) {
      const int on = parent[i];
      if (on < 0) continue;
      const double length = (position_of(character, i) - position_of(character, on)).norm();
      reach[on] = std::max(reach[on], reach[i] + length);
    }
  }
  // Whether fingers or toes begin at a body: several chains, or many bodies.
  bool branches(int body) const {
    const auto is_chain = [&](int one) { return reach[one] > 0.0; };
    return std::count_if(below[body].begin(), below[body].end(), is_chain) > 1 ||
           below[body].size() > 2;
  }
};

// Bodies of a limb: girdle (clavicle), upper bone, lower bone, end (hand, foot) and the first body
// of what is attached to the end; -1 for none.
struct Limb {
  int girdle = -1, upper = -1, lower = -1, end = -1, tip = -1;
  double length = 0.0;  // m, of upper and lower bone; 0: no limb
};

// The first bodies along the longest path down from one. Of bodies that lie at one position the
// last is taken, because it has the rotations of all.
std::vector<int> longest_chain(const Character& character, const Tree& tree, int body) {
  constexpr double kOneJoint = 0.02;  // share of the reach within which bodies are one joint
  constexpr size_t kMost = 12;        // bodies, more than shoulder, arm and finger of any rig
  std::vector<int> chain = {body};
  for (int now = body; now >= 0 && chain.size() < kMost;) {
    int next = -1;
    double most = 0.0;
    for (const int i : tree.below[now]) {
      const double longest =
          tree.reach[i] + (position_of(character, i) - position_of(character, now)).norm();
      if (longest > most) most = longest, next = i;
    }
    if (next >= 0) {
      const Vec3 step = position_of(character, next) - position_of(character, chain.back());
      if (step.norm() > kOneJoint * tree.reach[body]) {
        chain.push_back(next);
      } else {
        chain.back() = next;
      }
    }
    now = next;
  }
  return chain;
}

// A chain of bodies, and what may be a limb of it.
struct Chain {
  const Character& character;
  std::vector<int> bodies;
  std::vector<double> way = {0.0};  // m, along it
  std::vector<char> branching;

  Chain(const Character& character, const Tree& tree, int body)
      : character(character), bodies(longest_chain(character, tree, body)) {
    for (size_t k = 1; k < bodies.size(); ++k) way.push_back(way.back() + length(k - 1, k));
    for (const int one : bodies) branching.push_back(tree.branches(one));
  }
  double length(size_t from, size_t to) const {
    return (position_of(character, bodies[to]) - position_of(character, bodies[from])).norm();
  }
  // How likely two long bones are from i to j and from j to k (m; 0: not at all), each of one body
  // or, with bodies that only twist it, of several in a line. Long ones of a person's proportions
  // are, and such that end in a hand or foot; bones of many bodies are less.
  double likely(size_t i, size_t j, size_t k) const {
    constexpr double kStraight = 1.03;  // of a bone's length: the way through its bodies
    constexpr double kLeast = 0.3;      // of the upper bone's length, the lower one's
    constexpr double kUsual = 1.1;      // times it: of rigs, between a person's and equal bones
    constexpr double kMerged = 0.82;    // less likely by it for each body within a bone ...
    constexpr double kBranches = 1.35;  // ... and more for an end from which fingers or toes go out
    const double upper = length(i, j), lower = length(j, k);
    if (way[j] - way[i] > kStraight * upper || way[k] - way[j] > kStraight * lower) return 0.0;
    if (lower < kLeast * upper) return 0.0;
    const double ratio = upper / lower / kUsual;
    double likely = (upper + lower) * std::min(ratio, 1.0 / ratio);
    for (size_t inner = i + 2; inner < k; ++inner) likely *= kMerged;
    return branching[k] ? kBranches * likely : likely;
  }
  Limb limb(size_t i, size_t j, size_t k) const {
    return {i > 0 ? bodies[i - 1] : -1,
            bodies[i],
            bodies[j],
            bodies[k],
            k + 1 < bodies.size() ? bodies[k + 1] : -1,
            length(i, j) + length(j, k)};
  }
};

struct LimbPair {
  int trunk = -1;
  Limb sides[2];
};

// The likeliest limbs along the longest paths down from two bodies, of the same bodies on either
// side and nearly equal lengths; of length 0 where there are none.
LimbPair pair_of(int trunk, const Chain& one, const Chain& other) {
  constexpr double kAlike = 0.2;  // of a length
  constexpr double kApart = 0.3;  // of the upper bone's length, where the limbs begin
  constexpr size_t kGirdle = 3;   // bodies before the limb, at most
  const Character& character = one.character;
  const auto alike = [&](size_t from, size_t to) {
    return std::abs(one.length(from, to) - other.length(from, to)) < kAlike * one.length(from, to);
  };
  const auto are_apart = [&](size_t i, size_t j) {
    return (position_of(character, one.bodies[i]) - position_of(character, other.bodies[i]))
               .norm() > kApart * one.length(i, j);
  };
  const size_t bodies = std::min(one.bodies.size(), other.bodies.size());
  LimbPair pair{trunk, {}};
  double best = 0.0;
  for (size_t i = 0; i <= kGirdle && i + 2 < bodies; ++i) {
    for (size_t j = i + 1; j + 1 < bodies; ++j) {
      if (!alike(i, j) || !are_apart(i, j)) continue;
      for (size_t k = j + 1; k < bodies; ++k) {
        const double likely = one.likely(i, j, k) * other.likely(i, j, k);
        if (likely <= best || !alike(j, k)) continue;
        best = likely;
        pair.sides[0] = one.limb(i, j, k);
        pair.sides[1] = other.limb(i, j, k);
      }
    }
  }
  return pair;
}

// Pairs of limbs that are attached to one trunk, longest first.
std::vector<LimbPair> limb_pairs(const Character& character) {
  const Tree tree(character);
  std::vector<LimbPair> pairs;
  for (int trunk = 0; trunk < character.skeleton.size(); ++trunk) {
    std::vector<Chain> chains;
    for (const int body : tree.below[trunk]) {
      if (tree.reach[body] > 0.0) chains.emplace_back(character, tree, body);
    }
    for (size_t a = 0; a < chains.size(); ++a) {
      for (size_t b = a + 1; b < chains.size(); ++b) {
        const LimbPair pair = pair_of(trunk, chains[a], chains[b]);
        if (pair.sides[0].length > 0.0) pairs.push_back(pair);
      }
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const LimbPair& a, const LimbPair& b) {
    return a.sides[0].length > b.sides[0].length;
  });
  return pairs;
}

Vec3 middle_of(const Character& character, const LimbPair& pair) {
  return Vec3(0.5 * (position_of(character, pair.sides[0].upper) +
                     position_of(character, pair.sides[1].upper)));
}

// Two pairs on one trunk, as of bones that are exported each on its own: the upper one has the
// arms.
bool on_one_trunk(const Character& character, const std::vector<LimbPair>& pairs, LimbPair& arms,
                  LimbPair& legs) {
  constexpr double kLevel = 0.3;  // of a length: sides of a pair lie beside each other
  const auto height = [&](const Limb& limb) { return position_of(character, limb.upper).y(); };
  const auto is_level = [&](const LimbPair& pair) {
    return std::abs(height(pair.sides[0]) - height(pair.sides[1])) < kLevel * pair.sides[0].length;
  };
  for (size_t k = 1; k < pairs.size(); ++k) {
    for (size_t j = 0; j < k; ++j) {
      if (pairs[j].trunk != pairs[k].trunk || !is_level(pairs[j]) || !is_level(pairs[k])) continue;
      const double over = middle_of(character, pairs[j]).y() - middle_of(character, pairs[k]).y();
      if (std::abs(over) < kLevel * pairs[k].sides[0].length) continue;
      arms = pairs[over > 0.0 ? j : k], legs = pairs[over > 0.0 ? k : j];
      return true;
    }
  }
  return false;
}

// The two longest pairs of which one is attached to a descendant of the other's trunk: that one has
// the arms. Of a person without legs the longest pair has them.
bool arms_and_legs(const Character& character, LimbPair& arms, LimbPair& legs) {
  constexpr double kShortest = 0.35;  // of the legs' length
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
      if (lower.sides[0].length < kShortest * upper.sides[0].length) continue;
      arms = lower, legs = upper;
      return true;
    }
  }
  if (on_one_trunk(character, pairs, arms, legs)) return true;
  if (pairs.empty()) return false;
  arms = pairs.front();
  return true;
}

// Direction to the person's left. `feet` tells whether the toes gave it; without toes the person is
// taken to face along z, as in glTF.
Vec3 left_of(const Character& character, const LimbPair& arms, const LimbPair& legs, bool& feet) {
  const Vec3 up = legs.trunk < 0
                      ? Vec3::UnitY()
                      : Vec3(middle_of(character, arms) - middle_of(character, legs)).normalized();
  Vec3 forward = Vec3::Zero();
  double length = 0.0;
  for (const Limb& leg : legs.sides) {
    if (leg.end < 0 || leg.tip < 0) continue;
    const Vec3 foot = position_of(character, leg.tip) - position_of(character, leg.end);
    forward += foot - foot.dot(up) * up;
    length += foot.norm();
  }
  feet = length > 0.0 && forward.norm() > 0.1 * length;
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
  if (legs.trunk < 0 && !(no_arms && no_legs)) return "";
  bool feet = false, named_sides = true;
  const Vec3 left = left_of(character, arms, legs, feet);
  std::string summary;
  const auto put = [&](const LimbPair& pair, std::initializer_list<BoneKind> kinds,
                       const char* what) {
    const Vec3 across =
        position_of(character, pair.sides[0].upper) - position_of(character, pair.sides[1].upper);
    const auto bodies_of = [&](int k) {
      const Limb& limb = pair.sides[k];
      return std::vector<int>{limb.girdle, limb.upper, limb.lower, limb.end};
    };
    int first = side_by_names(character.skeleton, bodies_of(0), bodies_of(1));
    if (first == 0) {
      named_sides = false;
      first = across.dot(left) > 0.0 ? 1 : -1;
    }
    for (int k = 0; k < 2; ++k) {
      const int side = k == 0 ? first : -first;
      const std::vector<int> of = bodies_of(k);
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
  if (no_legs && legs.trunk >= 0) {
    put(legs, {BoneKind::kNone, BoneKind::kThigh, BoneKind::kShin, BoneKind::kFoot}, "leg");
  }
  add_trunk(character.skeleton, bodies);
  return summary + (named_sides ? ", left and right by their names"
                    : feet      ? ", left and right by the feet"
                                : ", taken to look along z");
}

}  // namespace thew::rig
