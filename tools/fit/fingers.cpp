// SPDX-License-Identifier: Apache-2.0
//
// The template's hand in a character's that has fingers of its own: each bone in its own finger.
#include <algorithm>
#include <cmath>

#include "rig/character_bones.h"
#include "rig/math.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

constexpr size_t kMostFingers = 5;
constexpr size_t kFewest = 2;       // bodies of a finger
constexpr size_t kPhalanges = 3;    // a finger's, and a thumb's with its metacarpal
constexpr double kAtWrist = 0.1;    // of the hand's length: what begins nearer is no finger
constexpr double kThumb = 0.8;      // nearer to the wrist than the other fingers begin, in the mean
constexpr double kAway = 0.4;       // of the palm's length: a thumb as far off lacks its metacarpal
constexpr double kShort = 0.5;      // of the template's metacarpal on this palm: not all of one
constexpr double kTip = 0.85;       // of the last phalanx' length, where its bone ends
constexpr double kRound = 0.8;      // of it, where the fingertip begins to be round
constexpr double kSkin = 0.05;      // of a finger's radius, outside of its bones
constexpr double kOwnSkin = 0.5;    // of a vertex' weights: a finger's
constexpr double kOffJoint = 0.25;  // of a phalanx: how far a joint may lie from the middle
constexpr double kAround = 0.6;     // of a phalanx, all round it: skin of its own finger
constexpr double kNarrowest = 0.15;  // of how broad the palm makes a bone
constexpr double kNarrower = 0.95;   // from trial to trial
constexpr double kWrist = 0.1;       // of the palm's length, in which bones go with the forearm's
constexpr int kSections = 5;         // in which a phalanx has to lie in its finger
constexpr int kPalmSections = 8;     // in which the palm's bones have to lie in the hand
constexpr double kPalm = 1.5;        // of the palm's length, all round it: the hand's skin

// The template's fingers in a character's with so many: what stays is the palm's breadth.
std::vector<std::string> names_of(size_t fingers) {
  if (fingers == 3) return {"thumb", "index", "little"};
  if (fingers == 4) return {"thumb", "index", "middle", "little"};
  return {"thumb", "index", "middle", "ring", "little"};
}

// From the knuckle on, in the pose of straight elbows.
struct Finger {
  std::vector<int> bodies;
  std::vector<Vec3> joints;  // m; the last is the tip, where its bone ends
};

double length_of(const std::vector<Vec3>& joints) {
  double sum = 0.0;
  for (size_t i = 1; i < joints.size(); ++i) sum += (joints[i] - joints[i - 1]).norm();
  return sum;
}

// Bodies below the hand, each chain's last kPhalanges that carry skin and have no second branch.
std::vector<std::vector<int>> chains_of(const Target& to) {
  const Skeleton& skeleton = to.character.skeleton;
  const std::vector<int> hands = hand_bodies(to.character, to.arm);
  const Vec3 wrist = to.arm.wrist_in(to.straight);
  double farthest = 0.0;
  std::vector<char> in_finger(skeleton.size(), 0);
  // Without the ends that Blender adds to the chains of an FBX file.
  const std::vector<char> has_skin = bodies_with_skin(to.character);
  for (int b = 0; b < skeleton.size(); ++b) {
    const auto carries = [&](int hand) { return hangs_on(skeleton, b, hand); };
    if (!has_skin[b] || b == to.arm.hand || std::none_of(hands.begin(), hands.end(), carries)) {
      continue;
    }
    in_finger[b] = 1;
    farthest = std::max(farthest, (to.straight[b].translation() - wrist).norm());
  }
  for (int b = 0; b < skeleton.size(); ++b) {
    if ((to.straight[b].translation() - wrist).norm() < kAtWrist * farthest) in_finger[b] = 0;
  }
  const auto above = [&](int body) {  // past helpers that carry nothing
    do body = skeleton.parent[body];
    while (body >= 0 && is_pivot(skeleton.body_names[body]));
    return body;
  };
  std::vector<int> branches(skeleton.size(), 0);
  for (int b = 0; b < skeleton.size(); ++b) {
    if (in_finger[b] && above(b) >= 0) ++branches[above(b)];
  }
  std::vector<std::vector<int>> chains;
  for (int leaf = 0; leaf < skeleton.size(); ++leaf) {
    if (!in_finger[leaf] || branches[leaf] > 0) continue;
    std::vector<int>& chain = chains.emplace_back();
    for (int b = leaf; b >= 0 && in_finger[b] && branches[b] <= 1 && chain.size() < kPhalanges;
         b = above(b)) {
      chain.insert(chain.begin(), b);
    }
    if (chain.size() < kFewest) chains.pop_back();  // what the hand holds or wears
  }
  return chains;
}

// Of the hand's skin, what mostly hangs on a finger.
TriMesh skin_of(const Target& to, const std::vector<int>& bodies) {
  const SkinWeights& weights = to.character.skin;
  const auto share = [&](int vertex) {
    double sum = 0.0;
    for (int k = weights.first[vertex]; k < weights.first[vertex + 1]; ++k) {
      const int on = weights.links[weights.link[k]].body;
      if (hangs_on(to.character.skeleton, on, bodies.front())) sum += weights.weight[k];
    }
    return sum;
  };
  TriMesh out{to.hand.vertices, {}};
  for (const Triangle& t : to.hand.triangles) {
    if (share(t[0]) + share(t[1]) + share(t[2]) >= 3.0 * kOwnSkin) out.triangles.push_back(t);
  }
  return out;
}

// Joints and the tip lie in the middle of the finger, where the character's own lie beside it.
void centre_joints(const Limb& skin, std::vector<Vec3>& joints) {
  const std::vector<Vec3> own = joints;
  const auto off = [&](const Vec3& at, const Vec3& way, double size) {
    const Vec3 along = way.normalized(), a = along.unitOrthogonal();
    const Limb::Section section = skin.section(at, a, along.cross(a), kAround * size);
    const Vec3 off = section.middle - at;
    return section.radius > 0.0 && off.norm() < kOffJoint * size ? off : Vec3(Vec3::Zero());
  };
  for (size_t i = 1; i + 1 < own.size(); ++i) {
    const double size = std::min((own[i] - own[i - 1]).norm(), (own[i + 1] - own[i]).norm());
    joints[i] += off(own[i], own[i + 1] - own[i - 1], size);
  }
  const Vec3 from = joints[joints.size() - 2], end = joints.back() - from;
  joints.back() += off(from + kRound * end, end, end.norm()) / kRound;
}

// Its last bone lies where the last body's skin does.
Finger finger_of(const Target& to, const std::vector<int>& bodies) {
  Finger finger{bodies, {}};
  for (const int b : bodies) finger.joints.push_back(to.straight[b].translation());
  const TriMesh end = skin_of(to, {bodies.back()});
  const Vec3 last = finger.joints.back();
  Vec3 middle = Vec3::Zero();
  for (const Triangle& t : end.triangles) {
    for (const int i : t) middle += end.vertices[i] - last;
  }
  const Vec3 along = middle.normalized();
  double farthest = 0.0;
  for (const Triangle& t : end.triangles) {
    for (const int i : t) farthest = std::max(farthest, along.dot(end.vertices[i] - last));
  }
  finger.joints.push_back(last + kTip * farthest * along);
  return finger;
}

// The thumb, then from the index on; empty where neither names nor places tell a thumb and two
// fingers.
std::vector<Finger> find_fingers(const Target& to) {
  const Vec3 wrist = to.arm.wrist_in(to.straight);
  std::vector<Finger> fingers;
  for (const std::vector<int>& chain : chains_of(to)) {
    const TriMesh skin = skin_of(to, chain);
    Finger finger = finger_of(to, chain);
    if (skin.triangles.empty() || !(length_of(finger.joints) > 0.0)) continue;
    centre_joints(Limb(skin), finger.joints);
    fingers.push_back(finger);
  }
  if (fingers.size() < 3) return {};
  const auto begins = [&](const Finger& finger) { return (finger.joints[0] - wrist).norm(); };
  const auto is_called = [&](const Finger& finger) {
    const std::string name = to.name_of(finger.bodies[0]);
    return name.find("humb") != std::string::npos || name.find("HUMB") != std::string::npos;
  };
  auto thumb = std::find_if(fingers.begin(), fingers.end(), is_called);
  if (thumb == fingers.end()) {
    const auto nearer = [&](const Finger& a, const Finger& b) { return begins(a) < begins(b); };
    thumb = std::min_element(fingers.begin(), fingers.end(), nearer);
    double sum = -begins(*thumb);
    for (const Finger& finger : fingers) sum += begins(finger);
    if (begins(*thumb) > kThumb * sum / (fingers.size() - 1)) return {};
  }
  std::iter_swap(fingers.begin(), thumb);
  const Vec3 from = fingers[0].joints[1];
  std::sort(fingers.begin() + 1, fingers.end(), [&](const Finger& a, const Finger& b) {
    return (a.joints[0] - from).norm() < (b.joints[0] - from).norm();
  });
  if (fingers.size() > kMostFingers) fingers.resize(kMostFingers);
  return fingers;
}

// The palm: from the wrist to the knuckles, and from the index to the last finger.
struct Palm {
  Vec3 wrist;
  std::vector<Vec3> knuckles;  // m, from the index on
  Mat3 axes;                   // columns: along, across, out of the palm
  double length, breadth;      // m

  Palm(const Vec3& wrist, const std::vector<Vec3>& knuckles) : wrist(wrist), knuckles(knuckles) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : knuckles) mean += (p - wrist) / static_cast<double>(knuckles.size());
    const Vec3 along = mean.normalized(), row = knuckles.back() - knuckles.front();
    const Vec3 across = (row - row.dot(along) * along).normalized();
    axes << along, across, along.cross(across);
    length = mean.norm();
    breadth = across.dot(row);
  }
  Vec3 local(const Vec3& p) const { return axes.transpose() * (p - wrist); }
};

// One palm onto another, knuckle onto knuckle.
struct PalmMap {
  Palm from, to;
  Vec3 scale;
  std::vector<Vec3> off;  // m, from where all but this brings a knuckle

  PalmMap(Palm from_palm, Palm to_palm) : from(std::move(from_palm)), to(std::move(to_palm)) {
    scale = Vec3(to.length / from.length, to.breadth / from.breadth, 0.0);
    scale.z() = std::min(scale.x(), scale.y());
    find_off();
  }
  void find_off() {
    off.clear();
    for (size_t i = 0; i < from.knuckles.size(); ++i) {
      off.push_back(to.knuckles[i] - evenly(from.knuckles[i]));
    }
  }
  // Its bones, and the wrist's; the knuckles stay.
  void narrow(double share) {
    scale.y() *= share;
    scale.z() *= share;
    find_off();
  }
  Vec3 evenly(const Vec3& p) const {
    return to.wrist + to.axes * scale.cwiseProduct(from.local(p));
  }
  // Of p, by how much each knuckle's own way counts: between two of them linearly.
  Vec3 placed(const Vec3& p) const {
    const double across = from.local(p).y();
    size_t i = 0;
    while (i + 2 < off.size() && from.local(from.knuckles[i + 1]).y() < across) ++i;
    const double here = from.local(from.knuckles[i]).y();
    const double next = from.local(from.knuckles[i + 1]).y();
    const double share = std::clamp((across - here) / (next - here), 0.0, 1.0);
    const double way = std::clamp(from.local(p).x() / from.length, 0.0, 1.0);
    return evenly(p) + way * ((1.0 - share) * off[i] + share * off[i + 1]);
  }
  // Before the wrist where it was.
  Vec3 blended(const Vec3& p) const {
    const double end = kWrist * from.length, beyond = smoothstep(-end, end, from.local(p).x());
    return p + beyond * (placed(p) - p);
  }
};

// Makes the palm's bones as narrow as the hand asks for.
void narrow(const Limb& hand, const std::vector<Vec3>& points, PalmMap& palm) {
  const Vec3 along = palm.to.axes.col(0);
  const double widest = palm.scale.z(), step = palm.to.length / kPalmSections;
  for (int i = 0; i < kPalmSections; ++i) {
    const Vec3 at = palm.to.wrist + (i + 0.5) * step * along;
    const Limb::Section section =
        hand.section(at, palm.to.axes.col(1), palm.to.axes.col(2), kPalm * palm.to.length);
    if (!(section.within(at) > 0.0)) continue;  // a joint beside the hand
    for (const Vec3& p : points) {
      const double place = along.dot(palm.placed(p) - palm.to.wrist);
      if (place < i * step || place > (i + 1) * step) continue;
      while (palm.scale.z() > kNarrowest * widest && section.within(palm.placed(p)) < 0.0) {
        palm.narrow(kNarrower);
      }
    }
  }
}

// A template's phalanx from joint to joint, and where it goes.
struct Phalanx {
  Vec3 a, b, to_a, to_b;
  Mat3 turn;
  double across;

  Vec3 placed(const Vec3& p) const {
    const Vec3 along = (b - a).normalized(), to_along = (to_b - to_a).normalized();
    const double at = along.dot(p - a);
    return to_a + at * (to_b - to_a).norm() / (b - a).norm() * to_along +
           across * (turn * (p - a - at * along));
  }
};

// Makes the bone as narrow as its finger asks for.
void narrow(const Limb& skin, const std::vector<Vec3>& points, Phalanx& bone) {
  const Vec3 way = bone.to_b - bone.to_a, along = way.normalized(), a = along.unitOrthogonal();
  const double widest = bone.across;
  for (int i = 0; i < kSections; ++i) {
    const double begin = 1.0 * i / kSections, end = (i + 1.0) / kSections;
    const Vec3 at = bone.to_a + 0.5 * (begin + end) * way;
    const Limb::Section section = skin.section(at, a, along.cross(a), kAround * way.norm());
    if (!(section.within(at) > kSkin * section.radius)) continue;  // it tells nothing of this bone
    for (const Vec3& p : points) {
      const double place = along.dot(bone.placed(p) - bone.to_a) / way.norm();
      if (place < begin || place > end) continue;
      while (bone.across > kNarrowest * widest &&
             section.within(bone.placed(p)) < kSkin * section.radius) {
        bone.across *= kNarrower;
      }
    }
  }
}

// Of the template's bones in a finger as many as the character's has bodies; a thumb of two has its
// metacarpal in the palm.
std::vector<HandBone*> bones_of(const Target& to, const std::string& name, size_t count,
                                std::vector<HandBone>& bones) {
  std::vector<HandBone*> parts;
  for (HandBone& bone : bones) {
    if (to.from.skeleton.body_names[bone.of_template].starts_with(name)) parts.push_back(&bone);
  }
  while (parts.size() > count) parts.erase(parts.begin() + (name == "thumb" ? 0 : 1));
  return parts;
}

// m, the farthest from the joint of a bone.
Vec3 end_of(const HandBone& bone) {
  const auto& x = bone.mesh.vertices;
  return *std::max_element(x.begin(), x.end(), [&](const Vec3& p, const Vec3& q) {
    return (p - bone.joint).norm() < (q - bone.joint).norm();
  });
}

// Places a bone, which lies in the straight pose, between two joints, as narrow as `skin` asks for.
void place(const PalmMap& palm, const Vec3& from, const Vec3& to, const Limb& skin, int body,
           HandBone& part) {
  Phalanx bone{part.joint, end_of(part), from, to, {}, 0.0};
  const Mat3 turn = palm.to.axes * palm.from.axes.transpose();
  const Vec3 own = bone.b - bone.a, way = to - from;
  bone.turn = least_turn(turn * own.normalized(), way.normalized()) * turn;
  bone.across = std::min(palm.scale.z(), way.norm() / own.norm());
  narrow(skin, part.mesh.vertices, bone);
  for (Vec3& p : part.mesh.vertices) p = bone.placed(p);
  part.body = body;
}

// A finger's bones on its bodies.
void fit_finger(const Target& to, const Finger& finger, const std::string& name,
                const PalmMap& palm, std::vector<HandBone>& bones) {
  const TriMesh around = skin_of(to, finger.bodies);
  const Limb skin(around), hand(to.hand);  // its first bone may lie in the palm
  std::vector<Vec3> joints = finger.joints;
  if (name == "thumb") {
    HandBone& metacarpal = *bones_of(to, name, kPhalanges, bones).front();
    const Vec3 on_wrist = palm.placed(metacarpal.joint);
    const bool is_far = (joints[0] - on_wrist).norm() > kAway * palm.to.length;
    const double whole = palm.scale.x() * (end_of(metacarpal) - metacarpal.joint).norm();
    const bool is_short = (joints[1] - joints[0]).norm() < kShort * whole;
    // One that begins with its knuckle, or in the web, begins at the wrist all the same.
    if ((is_far || is_short) && finger.bodies.size() == kPhalanges) joints[0] = on_wrist;
    if (is_far && finger.bodies.size() < kPhalanges) {
      place(palm, on_wrist, joints[0], hand, to.arm.hand, metacarpal);
    }
  }
  const std::vector<HandBone*> parts = bones_of(to, name, finger.bodies.size(), bones);
  for (size_t s = 0; s < parts.size(); ++s) {
    place(palm, joints[s], joints[s + 1], s == 0 ? hand : skin, finger.bodies[s], *parts[s]);
  }
}

}  // namespace

std::function<Vec3(const Vec3&)> fit_fingers(const Target& to, std::vector<HandBone>& bones) {
  const std::vector<Finger> fingers = find_fingers(to);
  if (fingers.empty()) return {};
  const std::vector<std::string> names = names_of(fingers.size());
  const int wrist = find_body(to.from.skeleton, "hand");
  const Transform hang = to.fit.hang, back = hang.inverse();
  const auto straight = [&](int body) {  // of the template
    return Vec3(back * to.mapped(to.from.rest[body].translation()));
  };
  std::vector<HandBone> placed = bones;
  for (HandBone& bone : placed) {
    bone.joint = straight(bone.of_template);
    for (Vec3& p : bone.mesh.vertices) p = back * p;
  }
  std::vector<Vec3> own, theirs;
  for (size_t f = 1; f < fingers.size(); ++f) {
    own.push_back(straight(find_body(to.from.skeleton, names[f] + "_proximal")));
    theirs.push_back(fingers[f].joints[0]);
  }
  PalmMap palm(Palm(straight(wrist), own), Palm(to.arm.wrist_in(to.straight), theirs));
  if (!(palm.to.length > 0.0 && palm.to.breadth > 0.0)) return {};
  for (HandBone& bone : placed) {
    if (bone.of_template != wrist) continue;
    narrow(Limb(to.hand), bone.mesh.vertices, palm);
    for (Vec3& p : bone.mesh.vertices) p = palm.blended(p);
  }
  for (size_t f = 0; f < fingers.size(); ++f) {
    fit_finger(to, fingers[f], names[f], palm, placed);
  }
  // A character with three fingers has no little one.
  std::erase_if(placed, [](const HandBone& bone) { return bone.body < 0; });
  for (HandBone& bone : placed) {
    for (Vec3& p : bone.mesh.vertices) p = hang * p;
  }
  bones = std::move(placed);
  return [=](const Vec3& p) { return Vec3(hang * palm.blended(back * p)); };
}

}  // namespace thew::tools
