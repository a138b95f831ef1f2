// SPDX-License-Identifier: Apache-2.0
//
// thew new on hands with fingers: each of the hand's bones lies in its own finger and moves with
// it.
#include <algorithm>
#include <map>

#include "tests/unit/tools/fit/new_figure.h"

namespace thew::tests {
namespace {

constexpr double kRadius = 0.007;  // m, of a finger
constexpr int kAround = 8;

// A tube along the joints, closed at both ends; each of its rings hangs on the joint before it.
void add_tube(const std::vector<Vec3>& joints, int first_body, Figure::Mesh& mesh) {
  constexpr int kRings = 6;  // to a phalanx
  const Vec3 along = (joints.back() - joints.front()).normalized(), a = along.unitOrthogonal(),
             b = along.cross(a);
  const int start = static_cast<int>(mesh.positions.size());
  const auto add = [&](const Vec3& p, int body) {
    mesh.positions.push_back(p);
    mesh.joints.push_back({static_cast<std::uint8_t>(body), 0, 0, 0});
    mesh.weights.push_back({1.0f, 0.0f, 0.0f, 0.0f});
  };
  int rings = 0;
  for (size_t s = 0; s + 1 < joints.size(); ++s) {
    for (int r = s == 0 ? 0 : 1; r <= kRings; ++r, ++rings) {
      const double share = 1.0 * r / kRings;
      for (int k = 0; k < kAround; ++k) {
        const SinCos at = sin_cos(2.0 * kPi * k / kAround);
        add((1.0 - share) * joints[s] + share * joints[s + 1] + kRadius * (at.cos * a + at.sin * b),
            first_body + static_cast<int>(s));
      }
    }
  }
  const int low = static_cast<int>(mesh.positions.size()), high = low + 1;
  add(joints.front(), first_body);
  add(joints.back(), first_body + static_cast<int>(joints.size()) - 2);
  for (int k = 0; k < kAround; ++k) {
    const int next = (k + 1) % kAround, last = start + (rings - 1) * kAround;
    mesh.triangles.push_back({low, start + next, start + k});
    mesh.triangles.push_back({high, last + k, last + next});
    for (int r = 0; r + 1 < rings; ++r) {
      const int here = start + r * kAround, there = here + kAround;
      mesh.triangles.push_back({here + k, here + next, there + k});
      mesh.triangles.push_back({there + k, here + next, there + next});
    }
  }
}

// Where each finger's bodies begin and where the last of them ends, by the name of its first body.
using Fingers = std::map<std::string, std::vector<Vec3>>;

// The figure's hands end at the knuckles; from there on spread fingers of two or three phalanges.
// Their names tell neither the fingers nor their order.
// The thumb's begin `thumb_at` (m) along the hand, and its first is so much shorter (m).
Fingers add_fingers(int fingers, int phalanges, Figure& figure, double thumb_at = 0.015,
                    double shorter = 0.0) {
  Fingers added;
  const Vec3 wrist(0.53, 1.075, 0.02), middle = wrist + Vec3(-0.007, 0.007, 0.006);  // of the hand
  const Vec3 along = (wrist - Vec3(0.37, 1.21, -0.035)).normalized(), ahead = Vec3::UnitZ();
  const Vec3 across = (ahead - ahead.dot(along) * along).normalized();  // where the thumb is
  for (Vec3& p : figure.meshes[0].positions) {
    const double side = p.x() < 0.0 ? -1.0 : 1.0;
    const Vec3 left(side * p.x(), p.y(), p.z());
    const double beyond = along.dot(left - wrist);
    if (left.x() < wrist.x() || beyond < 0.0) continue;
    const Vec3 now = left - 0.5 * beyond * along;
    p = Vec3(side * now.x(), now.y(), now.z());
  }
  for (const char* side : {"Left", "Right"}) {
    const auto mirrored = [&](const Vec3& p) {
      return Vec3(side[0] == 'L' ? p.x() : -p.x(), p.y(), p.z());
    };
    const auto hand = std::find_if(figure.joints.begin(), figure.joints.end(), [&](const auto& j) {
      return j.name == std::string(side) + "Hand";
    });
    const int on = static_cast<int>(hand - figure.joints.begin());
    Figure::Mesh& mesh = figure.meshes.emplace_back();
    mesh.name = std::string(side) + "Fingers";
    for (int f = 0; f < fingers; ++f) {
      const bool thumb = f == 0;
      const double place = thumb ? 0.03 : 0.025 - 0.05 * (f - 1) / (fingers - 2);  // m across
      const Vec3 knuckle = middle + (thumb ? thumb_at : 0.085) * along + place * across;
      const Vec3 way = (along + (thumb ? 0.9 : 8.0 * place) * across).normalized();
      std::vector<Vec3> joints;
      for (int k = 0; k <= phalanges; ++k) {
        joints.push_back(mirrored(knuckle + (0.028 * k - (thumb && k > 0 ? shorter : 0.0)) * way));
      }
      const int first = static_cast<int>(figure.joints.size());
      for (int k = 0; k < phalanges; ++k) {
        const std::string name =
            std::string(side) + "Digit" + std::to_string((f + 2) % fingers) + char('A' + k);
        figure.joints.push_back({name, k == 0 ? on : first + k - 1, joints[k]});
        added[name] = {joints[k], joints[k + 1]};
      }
      add_tube(joints, first, mesh);
    }
  }
  return added;
}

class NewFingers : public FigureScene {
 protected:
  Model made(const Figure& figure) { return built(options(figure), {}); }
};

struct Case {
  int fingers, phalanges;
  std::vector<std::string> names;  // of the template's fingers that are used
  bool ends = false;  // that no skin hangs on, as Blender adds them to what comes from FBX
};

// A joint at the end of each finger.
void add_ends(const Fingers& fingers, Figure& figure) {
  for (size_t i = 0, count = figure.joints.size(); i < count; ++i) {
    const auto is_below = [&](const Figure::Joint& joint) {
      return joint.parent == static_cast<int>(i);
    };
    const auto at = fingers.find(figure.joints[i].name);
    if (at == fingers.end() || std::any_of(figure.joints.begin(), figure.joints.end(), is_below)) {
      continue;
    }
    figure.joints.push_back({at->first + "_end", static_cast<int>(i), at->second[1]});
  }
}

// All in one they stood 12 mm out of spread fingers.
TEST_F(NewFingers, EachHasItsOwnBonesInIt) {
  const std::vector<Case> cases = {{5, 3, {"thumb", "index", "middle", "ring", "little"}},
                                   {4, 3, {"thumb", "index", "middle", "little"}},
                                   {4, 2, {"thumb", "index", "middle", "little"}},
                                   {4, 3, {"thumb", "index", "middle", "little"}, true}};
  for (const Case& of : cases) {
    SCOPED_TRACE(std::to_string(of.fingers) + " fingers of " + std::to_string(of.phalanges));
    Figure figure;
    const Fingers fingers = add_fingers(of.fingers, of.phalanges, figure);
    if (of.ends) add_ends(fingers, figure);
    const Model model = made(figure);
    size_t found = 0;
    double farthest = 0.0;
    for (const Bone& bone : model.bones) {
      const auto at = fingers.find(model.skeleton.body_names[bone.body]);
      const std::string name = bone.name.substr(0, bone.name.find('_'));
      const bool of_finger = std::count(of.names.begin(), of.names.end(), name) > 0;
      // The thumb's metacarpal may be the palm's.
      const bool on_finger = at != fingers.end() || bone.name.starts_with("thumb_metacarpal");
      EXPECT_EQ(of_finger, on_finger) << bone.name;
      if (!of_finger || at == fingers.end()) continue;
      ++found;
      const Vec3 &a = at->second[0], &b = at->second[1];
      const Vec3 along = (b - a).normalized();
      for (const Vec3& x : bone.in_body.vertices) {  // the figure's bodies are bound unturned
        farthest = std::max(farthest, (x - along.dot(x) * along).norm());
        EXPECT_GT(along.dot(x), -0.1 * (b - a).norm()) << bone.name;
        EXPECT_LT(along.dot(x), 1.1 * (b - a).norm()) << bone.name;
      }
    }
    std::printf("%d fingers of %d: %zu bones, at most %.1f mm off their middles\n", of.fingers,
                of.phalanges, found, 1e3 * farthest);
    EXPECT_EQ(found, 2 * of.phalanges * of.names.size());
    EXPECT_LT(farthest, kRadius);
  }
}

// Bones of such a thumb hung in the air beside the hand.
TEST_F(NewFingers, AThumbThatBeginsWithItsKnuckleIsOnTheWrist) {
  for (const int phalanges : {2, 3}) {
    Figure figure;
    add_fingers(4, phalanges, figure, 0.055);
    const Model model = made(figure);
    for (const char* side : {"left", "right"}) {
      std::vector<Vec3> hand, metacarpal;  // the figure's bodies are bound unturned
      for (const Bone& bone : model.bones) {
        if (bone.name == std::string("hand_") + side) hand = bone.in_body.vertices;
        if (bone.name == std::string("thumb_metacarpal_") + side)
          metacarpal = bone.in_body.vertices;
      }
      double least = 1.0;
      for (const Vec3& p : metacarpal) {
        for (const Vec3& q : hand) least = std::min(least, (p - q).norm());
      }
      std::printf("%d bodies, %s: %.1f mm apart\n", phalanges, side, 1e3 * least);
      EXPECT_LT(least, 4e-3);
    }
  }
}

// A thumb whose first joint lies in the web had a splinter for a metacarpal, off the palm.
TEST_F(NewFingers, AMetacarpalIsNoShorterThanItsHandAsksFor) {
  Figure figure;
  add_fingers(4, 3, figure, 0.012, 0.016);
  const Model model = made(figure);
  int found = 0;
  for (const Bone& bone : model.bones) {
    if (!bone.name.starts_with("thumb_metacarpal")) continue;
    double longest = 0.0;
    for (const Vec3& p : bone.in_body.vertices) {
      longest = std::max(longest, (p - bone.in_body.vertices[0]).norm());
    }
    EXPECT_GT(longest, 0.025) << bone.name;  // 12 mm from joint to joint
    ++found;
  }
  EXPECT_EQ(found, 2);
}

// A mitten has a hand of one piece.
TEST_F(NewFingers, OfOneBodyEachAreNone) {
  Figure figure;
  add_fingers(5, 1, figure);
  const Model model = made(figure);
  EXPECT_EQ(model.bones.size(), 10u);
}

}  // namespace
}  // namespace thew::tests
