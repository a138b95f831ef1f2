// SPDX-License-Identifier: Apache-2.0
//
// Anatomy of the arm's skin: its girths, the bulge over the biceps; it slides over the tip of the
// elbow, and it does not narrow between elbow and wrist when the forearm turns over.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "rig/math.h"
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

struct Cut {
  double girth = 0.0, area = 0.0;  // m, m^2; the area as by Green's theorem
  std::vector<Vec3> points;
};

// What the plane across y (m, in the humerus' frame, the upper arm hanging) cuts of a closed mesh.
Cut cut_across(const std::vector<Triangle>& triangles, const Points& x, double humerus, double y) {
  Cut cut;
  for (const Triangle& t : triangles) {
    std::vector<Vec3> ends;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = to_vec(x[t[k]]), b = to_vec(x[t[(k + 1) % 3]]);
      const double from = a.y() - humerus - y, to = b.y() - humerus - y;
      if ((from < 0.0) != (to < 0.0)) ends.push_back(a + from / (from - to) * (b - a));
    }
    if (ends.size() != 2) continue;
    const Vec3 side = ends[1] - ends[0];
    const Vec3 normal =
        (to_vec(x[t[1]]) - to_vec(x[t[0]])).cross(to_vec(x[t[2]]) - to_vec(x[t[0]]));
    const double sense = Vec3::UnitY().cross(normal).dot(side) < 0.0 ? -1.0 : 1.0;
    cut.girth += side.norm();
    cut.area += 0.5 * sense * Vec3::UnitY().dot(ends[0].cross(ends[1]));
    cut.points.insert(cut.points.end(), ends.begin(), ends.end());
  }
  return cut;
}

// m^2, of the convex hull of points of one plane across y (Andrew 1979).
double hull_area(std::vector<Vec3> points) {
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::pair(a.x(), a.z()) < std::pair(b.x(), b.z());
  };
  std::sort(points.begin(), points.end(), before);
  std::vector<Vec3> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t first = hull.size();
    for (const Vec3& p : points) {
      while (hull.size() >= first + 2 &&
             (hull.back() - hull[hull.size() - 2]).cross(p - hull.back()).y() >= 0.0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0.0;
  for (size_t i = 0; i < hull.size(); ++i) twice += hull[i].cross(hull[(i + 1) % hull.size()]).y();
  return 0.5 * std::abs(twice);
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

double humerus_of(const Moved& arm) {
  return arm.rest[arm.model.bones[bone_named(arm.model, "humerus")].body].translation().y();
}

// Volumes of the twelve and of what is not among them over the lengths of a measured arm
// (BodyParts3D), with skin and fat.
TEST(ArmSkin, HasTheGirthsOfAMan) {
  const Moved arm("elbow = [[1, 0], [2, 0]]");
  const auto girth = [&](double y) {
    return cut_across(arm.model.skin.surface.triangles, arm.skin, humerus_of(arm), y).girth;
  };
  const auto most = [&](double from, double to) {
    double largest = 0.0;
    for (double y = from; y >= to; y -= 0.005) largest = std::max(largest, girth(y));
    return largest;
  };
  EXPECT_NEAR(most(-0.08, -0.16), 0.294, 0.015);
  EXPECT_NEAR(most(-0.30, -0.40), 0.276, 0.015);
  double elbow = 1.0, wrist = 1.0;
  for (double y = -0.25; y > -0.32; y -= 0.005) elbow = std::min(elbow, girth(y));
  EXPECT_NEAR(elbow, 0.240, 0.010);
  for (double y = -0.36, before = 1.0; y > -0.52; y -= 0.005) {
    wrist = girth(y);
    EXPECT_LT(wrist, before + 1e-4) << "falls to the wrist, y " << y;
    before = wrist;
  }
  EXPECT_NEAR(wrist, 0.165, 0.008);
}

// People's muscles and bone fill 0.84 to 0.91 of it.
TEST(ArmSkin, MusclesAndBoneFillTheUpperArm) {
  const Moved arm("elbow = [[1, 0], [2, 0]]");
  double sum = 0.0;
  int count = 0;
  for (double y = -0.12; y > -0.245; y -= 0.02) {
    double area = 0.0;
    std::vector<Vec3> points;
    const auto add = [&](size_t surface, const Points& x) {
      const auto& triangles = arm.model.surfaces[surface].surface.triangles;
      const Cut cut = cut_across(triangles, x, humerus_of(arm), y);
      area += std::abs(cut.area);
      points.insert(points.end(), cut.points.begin(), cut.points.end());
    };
    const size_t muscles = arm.state.muscles.size();
    for (size_t m = 0; m < muscles; ++m) add(m, arm.state.muscles[m].x);
    const int humerus = bone_named(arm.model, "humerus");
    add(muscles + humerus, arm.state.bones[humerus].x);
    const double fill = area / hull_area(points);
    std::printf("y %.2f m: %.2f\n", y, fill);
    EXPECT_GT(fill, 0.72) << "y " << y;
    sum += fill;
    ++count;
  }
  EXPECT_GT(sum / count, 0.75);
}

TEST(ArmSkin, BulgesOverTheBiceps) {
  Moved arm("elbow = [[1, 0], [30, 90]]");
  const auto cut = [&](const Points& x, double y) {
    return cut_across(arm.model.skin.surface.triangles, x, humerus_of(arm), y);
  };
  // m, x of the skin's front over the middle of the biceps, z 0 to 2 cm.
  const auto front = [&](const Points& x, double y) {
    double most = -1.0;
    for (const Vec3& p : cut(x, y).points) {
      if (p.z() > 0.0 && p.z() < 0.02) most = std::max(most, p.x());
    }
    return most;
  };
  struct Upper {
    double girth = 0.0, front = -1.0, summit = 0.0;  // m
  };
  const auto measure = [&](const Points& x) {
    Upper upper;
    for (double y = -0.09; y > -0.2; y -= 0.005) {
      upper.girth = std::max(upper.girth, cut(x, y).girth);
      if (front(x, y) > upper.front) upper.front = front(x, y), upper.summit = y;
    }
    return upper;
  };
  for (int frame = 2; frame <= 30; ++frame) arm.go_to(frame);
  const Upper straight = measure(arm.skin), flexed = measure(arm.state.skin.x);
  const double grows = flexed.girth / straight.girth - 1.0;
  std::printf("girth by %.1f %%, summit from %.3f to %.3f m\n", 100.0 * grows, straight.summit,
              flexed.summit);
  EXPECT_GT(grows, 0.08);
  EXPECT_LT(grows, 0.14);
  EXPECT_GT(flexed.summit, straight.summit + 0.01) << "towards the shoulder";
  for (const double y : {-0.13, -0.14, -0.15, -0.16}) {
    const double rise = front(arm.state.skin.x, y) - front(arm.skin, y);
    EXPECT_GT(rise, 0.008) << "y " << y;
    EXPECT_LT(rise, 0.015) << "y " << y;
  }
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

// m^2, of the skin's sections across the hanging forearm.
std::map<double, double> section_areas(const Moved& arm, const Points& x) {
  constexpr double kElbow = -0.33, kWrist = -0.56, kApart = 0.004;  // m, y
  std::map<double, double> areas;
  for (double y = kElbow; y > kWrist; y -= kApart) {
    areas[y] = cut_across(arm.model.skin.surface.triangles, x, 0.0, y).area;
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

// RMS distances from many more iterations. Sweeps that went on as they are left by twelve 0.7 of
// what four left.
TEST(ArmSkin, ErrorsFallFasterThanIterationsGrow) {
  Moved arm("elbow = [[1, 0], [31, 70]]");
  const State settled = arm.state;
  const auto skin_by = [&](int iterations) {
    arm.state = settled;
    arm.model.skin.settings.iterations = iterations;
    for (int frame = 2; frame <= 16; ++frame) arm.go_to(frame);
    return arm.state.skin.x;
  };
  const Points balance = skin_by(96);
  const auto error_of = [&](int iterations) {
    const Points x = skin_by(iterations);
    double sum = 0.0;
    for (size_t i = 0; i < x.size(); ++i) sum += dot(x[i] - balance[i], x[i] - balance[i]);
    return std::sqrt(sum / x.size());
  };
  const double by_four = error_of(4), by_twelve = error_of(12);
  EXPECT_GT(by_four, 1e-5);  // m
  EXPECT_LT(by_twelve, 0.4 * by_four);
}

// Muscles feel no skin: they are the same, to the bit, without it. On the arm that turns, in frames
// in which a joint turns so fast that they are divided.
TEST(ArmSkin, IsNotFeltByTheMuscles) {
  const auto model_of = [](const std::vector<std::string>& overrides) {
    return build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/turn.toml", overrides));
  };
  const Model with = model_of({}), without = model_of({"skin.enabled=false"});
  ASSERT_TRUE(with.has_skin);
  ASSERT_FALSE(without.has_skin);
  Parallel parallel(2);
  StageSeconds seconds;
  State a = initial_state(with), b = initial_state(without);
  settle(with, parallel, a);
  settle(without, parallel, b);
  double fastest = 0.0;  // rad
  constexpr int kFrames = 16;
  for (int frame = 0; frame <= kFrames; ++frame) {
    if (frame > 0) {
      State scratch = a;
      fastest = std::max(fastest, turn_until(with, frame / with.fps, scratch));
      step_frame(with, frame / with.fps, parallel, a, seconds);
      step_frame(without, frame / with.fps, parallel, b, seconds);
    }
    for (size_t m = 0; m < a.muscles.size(); ++m) {
      const Points &x = a.muscles[m].x, &y = b.muscles[m].x;
      ASSERT_EQ(x.size(), y.size());
      for (size_t i = 0; i < x.size(); ++i) {
        ASSERT_EQ(to_vec(x[i]), to_vec(y[i]))
            << with.muscles[m].name << ", node " << i << ", after " << frame << " frames";
      }
    }
  }
  EXPECT_GT(fastest, with.skin.settings.max_turn);
}

}  // namespace
}  // namespace thew::tests
