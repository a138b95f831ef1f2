// SPDX-License-Identifier: Apache-2.0
#include "tools/author/hand.h"

#include <algorithm>

namespace thew::tools {
namespace {

// From the base of the third metacarpal, in mm: towards the fingers' tips, the little finger, the
// palm. The forearm hangs half turned, so that the palm faces the body.
Vec3 in_arm(double distal, double little, double palmar) {
  return Vec3(0.028, -0.572, 0.035) - 1e-3 * Vec3(little, distal, palmar);
}

// The fingers are spread by 5 to 9 degrees more than measured, so that a grid tells them apart.
// Radii (m) of a finger's skin at the base of its metacarpal, its joints, its tip; those of its
// bones at the joints and the tip. Breadths of men's fingers 18 to 20 mm, palm 28 mm thick.
std::array<Finger, 5> make_fingers() {
  const Vec3 palm = -Vec3::UnitZ();
  const Vec3 thumb_bends = Vec3(-0.75, -0.25, -0.60).normalized();
  const auto at = [](std::initializer_list<std::array<double, 3>> mm) {
    std::vector<Vec3> points;
    for (const auto& p : mm) points.push_back(in_arm(p[0], p[1], p[2]));
    return points;
  };
  return {{{"thumb",
            at({{-3, -16, 16}, {32, -39, 28}, {60, -45, 34}, {82, -49, 38}}),
            {0.0145, 0.0118, 0.0102, 0.0078},
            1.15,
            thumb_bends},
           {"index",
            at({{-3, -14, 2}, {67, -19, 3}, {106, -32, 9}, {125, -38, 22}, {139, -39, 33}}),
            {0.0130, 0.0098, 0.0090, 0.0081, 0.0068},
            1.0,
            palm},
           {"middle",
            at({{0, 0, 0}, {64, 1, 1}, {106, 1, 12}, {133, 2, 23}, {146, 4, 35}}),
            {0.0130, 0.0099, 0.0091, 0.0082, 0.0069},
            1.0,
            palm},
           {"ring",
            at({{-2, 11, 1}, {57, 19, 0}, {97, 28, 9}, {122, 35, 22}, {132, 38, 33}}),
            {0.0128, 0.0095, 0.0086, 0.0078, 0.0066},
            0.95,
            palm},
           {"little",
            at({{-3, 20, 4}, {49, 36, 3}, {81, 53, 8}, {101, 63, 15}, {113, 69, 21}}),
            {0.0125, 0.0090, 0.0078, 0.0071, 0.0060},
            0.85,
            palm}}};
}

// Two strokes from joint to joint, thinner between, with room for the joints.
void add_bone(const Finger& finger, size_t part, BoneShape& bone) {
  constexpr double kRadius[] = {0.0068, 0.0064, 0.0056, 0.0048, 0.0038}, kWaist = 0.78;
  constexpr double kRoom = 0.0006;               // m, of half a joint
  const size_t last = finger.points.size() - 1;  // the thumb's tip is thicker than its joints say
  const double from = finger.bone * kRadius[part], to = finger.bone * kRadius[part + 5 - 1 - last];
  const Vec3 &a = finger.points[part], &b = finger.points[part + 1];
  const Vec3 along = (b - a).normalized();
  const Vec3 begin = a + (from + kRoom) * along, end = b - (to + kRoom) * along;
  const Vec3 middle = 0.5 * (begin + end);
  const double waist = kWaist * 0.5 * (from + to);
  bone.strokes.push_back({begin, middle, from, waist});
  bone.strokes.push_back({middle, end, waist, to});
}

struct HandFlesh {
  BoneShape palm;
  std::array<BoneShape, 5> fingers;
};

HandFlesh make_flesh() {
  constexpr double kPalm = 0.014, kKnuckle = 0.006;  // m, over which strokes melt
  HandFlesh flesh;
  flesh.palm.blend = kPalm;
  flesh.palm.strokes = {
      {in_arm(-30, -9, 3), in_arm(-12, -9, 4), 0.0150, 0.0150},
      {in_arm(-30, 9, 3), in_arm(-12, 9, 4), 0.0150, 0.0150},
      {in_arm(0, -15, 13), in_arm(30, -33, 22), 0.0150, 0.0120},  // ball of the thumb
      {in_arm(5, 20, 11), in_arm(42, 33, 9), 0.0135, 0.0115},     // of the little finger
      {in_arm(58, -19, 5), in_arm(52, 33, 5), 0.0100, 0.0095}};   // below the fingers
  for (size_t f = 0; f < flesh.fingers.size(); ++f) {
    const Finger& finger = fingers()[f];
    flesh.fingers[f].blend = kKnuckle;
    for (size_t k = 0; k + 1 < finger.points.size(); ++k) {
      const bool is_in_palm = f > 0 && k == 0;
      (is_in_palm ? flesh.palm : flesh.fingers[f])
          .strokes.push_back(
              {finger.points[k], finger.points[k + 1], finger.flesh[k], finger.flesh[k + 1]});
    }
  }
  return flesh;
}

}  // namespace

const std::array<Finger, 5>& fingers() {
  static const std::array<Finger, 5> fingers = make_fingers();
  return fingers;
}

std::vector<FingerBone> finger_bones() {
  std::vector<FingerBone> bones;
  for (int k = 0; k < 3; ++k) {
    for (int f = 0; f < 5; ++f) {
      const Finger& finger = fingers()[f];
      const bool is_thumb = f == 0;
      const std::array<const char*, 3> parts = {is_thumb ? "metacarpal" : "proximal",
                                                is_thumb ? "proximal" : "middle", "distal"};
      const std::array<const char*, 3> joints = {is_thumb ? "cmc" : "mcp", is_thumb ? "mcp" : "pip",
                                                 is_thumb ? "ip" : "dip"};
      const std::array<double, 3> lower = {-30, is_thumb ? -10.0 : 0.0, -10};
      const std::array<double, 3> upper = {is_thumb ? 40.0 : 75.0, is_thumb ? 55.0 : 85.0, 60};
      const int part = is_thumb ? k : k + 1;
      const Vec3 along = finger.points[part + 1] - finger.points[part];
      bones.push_back({finger.name + "_" + parts[k], finger.name + "_" + joints[k], f, part,
                       along.cross(finger.bends_to).normalized(), lower[k], upper[k]});
    }
  }
  return bones;
}

BoneShape hand_bone() {
  BoneShape hand{"hand", 0.008, {0.0040, 0.0045, 0.0035}, {}, {}};
  // Two rows of the carpus and what joins them to the metacarpals. Near the joint's axis, so that a
  // bent hand keeps clear of the forearm.
  hand.strokes = {{{0.0175, -0.5500, 0.0320}, {0.0365, -0.5500, 0.0345}, 0.0085, 0.0085},
                  {{0.0140, -0.5610, 0.0330}, {0.0400, -0.5610, 0.0340}, 0.0080, 0.0080},
                  {{0.0120, -0.5700, 0.0325}, {0.0400, -0.5690, 0.0330}, 0.0075, 0.0075}};
  for (int f = 1; f < 5; ++f) add_bone(fingers()[f], 0, hand);
  return hand;
}

BoneShape shape_of(const FingerBone& bone) {
  BoneShape shape{bone.body, 0.003, Vec3::Constant(0.003), {}, {}};
  add_bone(fingers()[bone.finger], bone.part, shape);
  return shape;
}

double hand_level(const Vec3& p) {
  constexpr double kWeb = 0.010, kSkinWeb = 0.005;  // m, from finger to palm, between fingers
  static const HandFlesh flesh = make_flesh();
  double level = 1e9;
  for (const BoneShape& finger : flesh.fingers) {
    level = melt(level, bone_distance(finger, p), kSkinWeb);
  }
  return melt(level, bone_distance(flesh.palm, p), kWeb);
}

}  // namespace thew::tools
