// SPDX-License-Identifier: Apache-2.0
//
// The template's hand in the character's, which may be longer, shorter, a mitten or a fist.
#include <algorithm>
#include <cmath>
#include <memory>

#include "rig/math.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

constexpr double kEnd = 0.95;        // of the hand's length, where the fingers' bones end
constexpr double kWristPart = 0.05;  // of it, in which the wrist's bones go with the forearm's
constexpr double kStump = 0.25;      // of the forearm's length: what reaches no farther is no hand
constexpr double kShortest = 0.4;    // of the template's hand, a loose fist's of 64 mm
constexpr double kMostLonger = 1.6;  // beyond it the character holds something
constexpr double kNarrowestHand = 0.15;  // of how broad the forearm makes it
constexpr int kHandSections = 12;
constexpr double kShorter = 0.8;        // from trial to trial
constexpr double kHandNarrower = 0.95;  // from trial to trial
constexpr double kWidest = 1.5;         // of the hand's length: beyond it lies what the hand holds

// m along a unit vector, of the triangles' farthest corner.
double farthest(const TriMesh& mesh, const Vec3& from, const Vec3& along) {
  double most = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (const int i : t) most = std::max(most, along.dot(mesh.vertices[i] - from));
  }
  return most;
}

Vec3 middle_of(const TriMesh& mesh) {
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double share = (b - a).cross(c - a).norm();
    sum += share / 3.0 * (a + b + c);
    area += share;
  }
  return area > 0.0 ? Vec3(sum / area) : sum;
}

// The character's hand, and the line along which its bones lie.
struct Hand {
  Limb skin;
  Vec3 wrist, along, a, b;
  double length;              // m
  std::vector<Vec3> middles;  // m, off the straight line, from the wrist on

  Hand(const TriMesh& mesh, const Vec3& wrist, const Vec3& along);
  double at(const Vec3& p) const { return along.dot(p - wrist); }
  // 0 before the wrist, 1 beyond it.
  double beyond(const Vec3& p) const {
    return smoothstep(-kWristPart * length, kWristPart * length, at(p));
  }
  Limb::Section section(double at) const {
    return skin.section(wrist + at * along, a, b, kWidest * length);
  }
  // A point beside the straight line, beside the hand's middle and so much nearer to it.
  Vec3 placed(const Vec3& p, double share) const;
};

Hand::Hand(const TriMesh& mesh, const Vec3& wrist, const Vec3& along)
    : skin(mesh), wrist(wrist), along(along), a(along.unitOrthogonal()), b(along.cross(a)) {
  length = farthest(mesh, wrist, along);
  middles.push_back(Vec3::Zero());
  for (int i = 1; i <= kHandSections; ++i) {
    const double way = i * length / kHandSections;
    const Limb::Section of = section(way);
    middles.push_back(of.radius > 0.0 ? Vec3(of.middle - wrist - way * along) : middles.back());
  }
}

Vec3 Hand::placed(const Vec3& p, double share) const {
  const double place = std::clamp(at(p) / length, 0.0, 1.0) * kHandSections;
  const int i = std::min(static_cast<int>(place), kHandSections - 1);
  const Vec3 axis = wrist + at(p) * along;
  return axis + (i + 1 - place) * middles[i] + (place - i) * middles[i + 1] +
         (1.0 - beyond(p) * (1.0 - share)) * (p - axis);
}

// As narrow as the narrowest place asks for, so that fingers keep their shape.
double widest_in(const Hand& hand, const std::vector<Vec3>& points) {
  double share = 1.0;
  for (const Vec3& p : points) {
    if (hand.at(p) < kWristPart * hand.length) continue;
    const Limb::Section section = hand.section(hand.at(p));
    while (share >= kNarrowestHand && section.within(hand.placed(p, share)) < 0.0)
      share *= kHandNarrower;
  }
  return share;
}

}  // namespace

std::function<Vec3(const Vec3&)> fit_hand(const Target& to, TriMesh& bones) {
  const Transform hang = to.fit.hang;
  std::vector<Vec3> own = bones.vertices;
  for (Vec3& p : own) p = hang.inverse() * p;
  const Vec3 wrist = to.arm.wrist_in(to.straight);
  const Vec3 way = middle_of(to.hand) - wrist, own_way = middle_of({own, bones.triangles}) - wrist;
  if (to.hand.triangles.empty() || !(way.norm() > 1e-6) || !(own_way.norm() > 1e-6)) return {};
  const auto hand = std::make_shared<const Hand>(to.hand, wrist, way.normalized());
  const Mat3 turn = least_turn(own_way.normalized(), hand->along);
  double farthest_own = 0.0, reach = 0.0;
  for (Vec3& p : own) {
    p = wrist + turn * (p - wrist);
    farthest_own = std::max(farthest_own, hand->at(p));
  }
  for (const Triangle& t : to.hand.triangles) {
    for (const int i : t) reach = std::max(reach, (to.hand.vertices[i] - wrist).norm());
  }
  if (reach < kStump * (wrist - to.straight[to.arm.forearm].translation()).norm()) return {};
  const auto lengthened = [=](const Vec3& p, double longer) {
    return Vec3(p + (longer - 1.0) * hand->at(p) * hand->along);
  };
  // Where fingers are bent or spread, shorter bones end before that; where a hand comes to a point,
  // shorter ones may be broader: those that fill most of it.
  double longer = 0.0, share = 0.0;
  for (double trial = std::min(kMostLonger, kEnd * hand->length / farthest_own);
       trial >= kShortest && trial > longer * share; trial *= kShorter) {
    std::vector<Vec3> points = own;
    for (Vec3& p : points) p = lengthened(p, trial);
    const double widest = widest_in(*hand, points);
    if (widest >= kNarrowestHand && trial * widest > longer * share) longer = trial, share = widest;
  }
  if (longer == 0.0) return {};
  const auto placed = [=](const Vec3& p) {
    const Vec3 before = hang.inverse() * p, turned = wrist + turn * (before - wrist);
    const Vec3 after = hand->placed(lengthened(turned, longer), share);
    return Vec3(hang * (before + hand->beyond(turned) * (after - before)));
  };
  for (Vec3& p : bones.vertices) p = placed(p);
  return placed;
}

}  // namespace thew::tools
