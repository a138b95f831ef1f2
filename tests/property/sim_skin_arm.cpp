// SPDX-License-Identifier: Apache-2.0
//
// Anatomy of the arm's skin: it slides over the tip of the elbow, and it does not narrow between
// elbow and wrist when the forearm turns over.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

struct Moved {
  Model model;
  Parallel parallel{2};
  State state;
  Pose rest;    // bodies in the first frame
  Points skin;  // there

  explicit Moved(const std::string& keys)
      : model(build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml",
                                     {"rig.clip={ unit = \"deg\", keys = { " + keys + " } }"}))),
        state(initial_state(model)) {
    settle(model, parallel, state);
    rest = state.pose;
    skin = state.skin.x;
  }
  void go_to(int frame) {
    StageSeconds seconds;
    step_frame(model, (frame - 1) / model.fps, parallel, state, seconds);
  }
};

int bone_named(const Model& model, const std::string& name) {
  for (size_t b = 0; b < model.bones.size(); ++b) {
    if (model.bones[b].name == name) return static_cast<int>(b);
  }
  throw std::runtime_error("no bone " + name);
}

// The tip of the olecranon: the point of the ulna's upper 3 cm that is farthest back.
Vec3 tip_of_elbow(const Moved& arm) {
  const Points& ulna = arm.state.bones[bone_named(arm.model, "ulna")].x;
  double top = -1.0;
  for (const Point& x : ulna) top = std::max(top, x[1]);
  Vec3 tip = Vec3::Constant(1.0);
  for (const Point& x : ulna) {
    if (x[1] > top - 0.03 && x[0] < tip.x()) tip = to_vec(x);
  }
  return tip;
}

TEST(ArmSkin, SlidesOverTheTipOfTheElbow) {
  Moved arm("elbow = [[1, 0], [30, 130], [60, 0]]");
  const Vec3 tip = tip_of_elbow(arm);
  const int ulna = arm.model.bones[bone_named(arm.model, "ulna")].body;
  const auto slid = [&] {  // m, over the ulna, of the skin within 3 cm of the tip, in the mean
    const Transform back = arm.rest[ulna] * arm.state.pose[ulna].inverse();
    double sum = 0.0;
    int count = 0;
    for (size_t i = 0; i < arm.skin.size(); ++i) {
      const Vec3 was = to_vec(arm.skin[i]);
      if ((was - tip).norm() > 0.03) continue;
      sum += (back * to_vec(arm.state.skin.x[i]) - was).norm();
      ++count;
    }
    EXPECT_GT(count, 20);
    return sum / count;
  };
  for (int frame = 2; frame <= 30; ++frame) arm.go_to(frame);
  const double flexed = slid();
  for (int frame = 31; frame <= 60; ++frame) arm.go_to(frame);
  std::printf("%.1f mm at 130 degrees, %.2f mm back at 0\n", 1e3 * flexed, 1e3 * slid());
  EXPECT_GT(flexed, 0.01);
  EXPECT_LT(flexed, 0.04);
  EXPECT_LT(slid(), 5e-4);
}

// m^2, of the skin's sections across the hanging forearm, by Green's theorem over what the plane
// cuts of each triangle.
std::map<double, double> section_areas(const Moved& arm, const Points& x) {
  constexpr double kElbow = -0.33, kWrist = -0.56, kApart = 0.004;  // m, y
  std::map<double, double> areas;
  for (double y = kElbow; y > kWrist; y -= kApart) {
    double area = 0.0;
    for (const Triangle& t : arm.model.skin.surface.triangles) {
      std::vector<Vec3> cut;
      double turn = 0.0;  // whose sign tells in which direction the edge of the section runs
      for (int k = 0; k < 3; ++k) {
        const Vec3 a = to_vec(x[t[k]]), b = to_vec(x[t[(k + 1) % 3]]);
        if ((a.y() < y) == (b.y() < y)) continue;
        cut.push_back(a + (y - a.y()) / (b.y() - a.y()) * (b - a));
      }
      if (cut.size() != 2) continue;
      const Vec3 normal =
          (to_vec(x[t[1]]) - to_vec(x[t[0]])).cross(to_vec(x[t[2]]) - to_vec(x[t[0]]));
      turn = Vec3::UnitY().cross(normal).dot(cut[1] - cut[0]) < 0.0 ? -1.0 : 1.0;
      area += 0.5 * turn * Vec3::UnitY().dot(cut[0].cross(cut[1]));
    }
    areas[y] = area;
  }
  return areas;
}

TEST(ArmSkin, IsNotWrungByTheForearmsTurn) {
  for (const char* angle : {"80", "-80"}) {
    Moved arm(std::string("forearm_rotation = [[1, 0], [30, ") + angle + "]]");
    const auto before = section_areas(arm, arm.skin);
    for (int frame = 2; frame <= 30; ++frame) arm.go_to(frame);
    double least = 1e9;
    for (const auto& [height, area] : section_areas(arm, arm.state.skin.x)) {
      least = std::min(least, area / before.at(height));
    }
    std::printf("%s degrees: narrowest section %.3f of its area at rest\n", angle, least);
    EXPECT_GT(before.size(), 50u);
    EXPECT_GT(least, 0.9);
  }
}

}  // namespace
}  // namespace thew::tests
