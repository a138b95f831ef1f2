// SPDX-License-Identifier: Apache-2.0
//
// Contact that is harder than in any shot. Each case ends in a valid state or with an error that
// names muscle and node.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "muscles/volume.h"
#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/distance.h"

namespace thew::tests {
namespace {

struct Motion {
  Model model;
  State state;
  Parallel parallel{2};

  explicit Motion(const std::filesystem::path& scene,
                  const std::vector<std::string>& overrides = {})
      : model(build_model(read_scene(scene, overrides))), state(initial_state(model)) {
    settle(model, parallel, state);
  }
  // Each frame's volume and positions are checked; returns the last frame's measures.
  FrameMeasures go_to(int frame) {
    StageSeconds seconds;
    const int first = model.first_frame;
    for (int f = first + 1 + static_cast<int>(std::lround(state.time * model.fps)); f <= frame;
         ++f) {
      step_frame(model, (f - first) / model.fps, parallel, state, seconds);
      for (int m = 0; m < state.count(); ++m) {
        const Muscle& muscle = model.muscles[m];
        const double volume = enclosed_volume(state.muscles[m].x, muscle.rest.triangles);
        EXPECT_LE(std::abs(volume / muscle.rest_volume - 1.0), 1e-12) << "frame " << f;
      }
    }
    Measuring measuring = start_measuring(model, initial_state(model));
    return measure(model, measuring, parallel, state);
  }
  Vec3 centre_of(int m) const {
    Vec3 sum = Vec3::Zero();
    for (const Point& x : state.muscles[m].x) sum += to_vec(x);
    return sum / static_cast<double>(state.muscles[m].x.size());
  }
};

std::string ball_obj(double radius) {
  constexpr int kAround = 24, kRings = 15;
  std::string text = "v 0 " + std::to_string(radius) + " 0\n";
  for (int i = 1; i <= kRings; ++i) {
    const double a = M_PI * i / (kRings + 1);
    for (int k = 0; k < kAround; ++k) {
      const double b = 2.0 * M_PI * k / kAround;
      text += "v " + std::to_string(radius * std::sin(a) * std::cos(b)) + " " +
              std::to_string(radius * std::cos(a)) + " " +
              std::to_string(-radius * std::sin(a) * std::sin(b)) + "\n";
    }
  }
  text += "v 0 " + std::to_string(-radius) + " 0\n";
  const auto node = [&](int ring, int k) { return 2 + (ring - 1) * kAround + k % kAround; };
  const int pole = 2 + kRings * kAround;
  const auto face = [&](int a, int b, int c) {
    text += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  };
  for (int k = 0; k < kAround; ++k) {
    face(1, node(1, k), node(1, k + 1));
    for (int i = 1; i < kRings; ++i) {
      face(node(i, k), node(i + 1, k), node(i + 1, k + 1));
      face(node(i, k), node(i + 1, k + 1), node(i, k + 1));
    }
    face(node(kRings, k), pole, node(kRings, k + 1));
  }
  return text;
}

class Contacts : public TempFolder {
 protected:
  // A muscle like a biceps from (0, 0.15, 0) to (0, -0.15, 0), 18 mm thick, and two balls that
  // slide along x: `left` comes from -0.3 m, `right` from 0.3 m. Keys are displacements in metres.
  std::filesystem::path shot(double radius, const std::string& keys) const {
    write("ball.obj", ball_obj(radius));
    std::string rig = "<robot name=\"shot\"><link name=\"table\"/>";
    for (const auto& [name, at, axis] :
         {std::array{"left", "-0.3", "1"}, std::array{"right", "0.3", "-1"}}) {
      rig += std::string("<link name=\"") + name +
             "\"><visual><geometry><mesh filename=\"ball.obj\"/></geometry></visual></link>"
             "<joint name=\"" +
             name + "\" type=\"prismatic\"><parent link=\"table\"/><child link=\"" + name +
             "\"/><origin xyz=\"" + at + " 0 0\"/><axis xyz=\"" + axis +
             " 0 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>";
    }
    write("rig.urdf", rig + "</robot>");
    return write("scene.toml",
                 "[scene]\nfps = 24\nframes = \"1-48\"\nsettle = 0.2\ngravity = [0, 0, 0]\n[rig]\n"
                 "file = \"rig.urdf\"\n[rig.clip]\ninterpolation = \"linear\"\nkeys = " +
                     keys +
                     "\n[[muscle]]\nname = \"biceps\"\npath = [[\"table\", 0, 0.15, 0], "
                     "[\"table\", 0, -0.15, 0]]\nbelly = [0.03, 0.27]\nweights = \"left\"\n"
                     "profile = { around = 20, rings = 21, radius = [[0, 0.004], [0.2, 0.008], "
                     "[0.5, 0.018], [0.8, 0.008], [1, 0.004]] }\n");
  }
};

// How deep (m) the muscle's nodes are in the balls.
double depth_in_balls(const Motion& run, double radius) {
  double deepest = 0.0;
  for (const Point& x : run.state.muscles[0].x) {
    for (const char* name : {"left", "right"}) {
      const Transform& pose = run.state.pose[find_body(run.model.skeleton, name)];
      deepest = std::max(deepest, radius - (to_vec(x) - pose.translation()).norm());
    }
  }
  return deepest;
}

// 10 m/s: from 0.2 m before the belly to 6 mm into it in half a frame, and back.
TEST_F(Contacts, AFistOnTheBiceps) {
  constexpr double kFist = 0.045;
  Motion run(shot(kFist, "{ left = [[1, 0], [4, 0], [4.6, 0.243], [20, 0.243], [24, 0]] }"));
  const Points rest = run.state.muscles[0].x;
  const FrameMeasures hit = run.go_to(16);
  EXPECT_LT(depth_in_balls(run, kFist), 1e-3);
  EXPECT_LT(hit.contact_penetration, 1e-3);
  EXPECT_GT(largest_distance(rest, run.state.muscles[0].x), 0.004);
  run.go_to(48);
  EXPECT_LT(largest_distance(rest, run.state.muscles[0].x), 5e-4);  // as before
}

// A ball that would be through and behind the muscle in one frame meets it all the same.
TEST_F(Contacts, ABallThatIsThroughInOneFrame) {
  constexpr double kBall = 0.012;
  Motion run(shot(kBall, "{ left = [[1, 0], [3, 0.2], [4, 0.4], [12, 0.4]] }"));
  run.go_to(3);
  const double before = run.centre_of(0).x();
  const FrameMeasures through = run.go_to(4);
  EXPECT_GT(run.centre_of(0).x(), before + 5e-4) << "nothing was met";
  EXPECT_LT(through.contact_penetration, 0.006);
}

// A covered ball keeps the muscle off by gap and cover, a covered muscle by both covers.
TEST_F(Contacts, AThicknessIsKeptFree) {
  constexpr double kBall = 0.045;
  const std::filesystem::path scene = shot(kBall, "{ left = [[1, 0], [12, 0.235], [48, 0.235]] }");
  const double gap = ContactSettings{}.gap;
  double last = -1.0;
  for (const auto& [cover, kept] : std::vector<std::pair<std::string, double>>{
           {"{}", 0.0}, {"{ left = 0.004 }", 0.004}, {"{ left = 0.004, biceps = 0.002 }", 0.006}}) {
    Motion run(scene, {"contact.thickness=" + cover});
    run.go_to(40);
    const Vec3 centre = run.state.pose[find_body(run.model.skeleton, "left")].translation();
    double off = 1.0;
    for (const Point& x : run.state.muscles[0].x) {
      off = std::min(off, (to_vec(x) - centre).norm() - kBall);
    }
    std::printf("thickness %s: nearest node %.3f mm off the ball\n", cover.c_str(), 1e3 * off);
    // The ball's flat faces lie 0.3 mm within its sphere, and normals lean to the muscle's own.
    EXPECT_GT(off, gap + kept - 5e-4);
    EXPECT_GT(off, last);
    last = off;
  }
  EXPECT_THROW(Motion(scene, {"contact.thickness={ lefty = 0.004 }"}), Error);
}

TEST_F(Contacts, PinchedBetweenTwoBones) {
  constexpr double kBall = 0.02;
  // The gap of 36 mm closes to 10 mm, then to 4.
  Motion run(shot(kBall,
                  "{ left = [[1, 0.262], [10, 0.275], [20, 0.275], [30, 0.278], [40, 0.278]],"
                  " right = [[1, 0.262], [10, 0.275], [20, 0.275], [30, 0.278], [40, 0.278]] }"));
  EXPECT_LT(run.go_to(20).contact_penetration, 5e-4);
  EXPECT_LT(run.go_to(40).contact_penetration, 5e-4);
  EXPECT_LT(depth_in_balls(run, kBall), 1e-3);
}

// A ball is squeezed between planes to a share of its height and kept there. No node is inside a
// plane, and the end is a flat disc, no wider than its volume needs and without a spike.
TEST(ContactsOfBall, SqueezedToATwentieth) {
  constexpr double kRadius = 0.1;
  for (const double share : {0.3, 0.1, 0.05}) {
    const std::string way = std::to_string(kRadius * (1.0 - share));
    Motion run(THEW_SOURCE_DIR "/assets/paper/ball.toml",
               {"solver.integrator=local_global", "solver.iterations=40",
                "rig.clip.keys={ top = [[1, 0], [31, " + way + "]], bottom = [[1, 0], [31, " + way +
                    "]] }"});
    for (int f = 2; f <= 46; ++f) {
      run.go_to(f);
      const double half = kRadius - run.state.joints[find_body(run.model.skeleton, "top")];
      for (const Point& x : run.state.muscles[0].x) {
        ASSERT_LE(std::abs(x[1]), half + 1e-12) << "frame " << f << " at " << share;
      }
    }
    const double height = 2.0 * kRadius * share;
    const double cake = std::sqrt(run.model.muscles[0].rest_volume / (M_PI * height));
    double widest = 0.0;
    for (const Point& x : run.state.muscles[0].x) {
      widest = std::max(widest, std::hypot(x[0], x[2]));
    }
    std::printf("squeezed to %g %%: %.1f mm wide, a disc %.1f\n", 100.0 * share, 1e3 * widest,
                1e3 * cake);
    EXPECT_GT(widest, cake);
    EXPECT_LT(widest, cake + 0.5 * height + 0.05 * cake);
  }
}

TEST(ContactsOfPair, HalfInsideEachOtherAreToldAndParted) {
  const std::string scene = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  Motion run(scene, {"skin.enabled=false", "muscle.side.path.0.3=0.016",
                     "muscle.side.path.1.3=0.016", "scene.settle=2"});
  const std::vector<std::string> overlaps = rest_overlaps(run.model);
  ASSERT_EQ(overlaps.size(), 1u);
  EXPECT_NE(overlaps[0].find("\"front\" and \"side\" overlap at rest, by "), std::string::npos)
      << overlaps[0];
  const FrameMeasures apart = run.go_to(16);
  EXPECT_LT(apart.contact_penetration, 1e-3);
}

const std::string kArm = THEW_SOURCE_DIR "/assets/arm/arm.toml";

// Flexion from 0 to 130 degrees in one frame ends in the same shape as a slow one.
TEST(ContactsOfArm, FlexedInOneFrame) {
  const std::string linear = "rig.clip.interpolation=linear";
  Motion slow(kArm, {linear, "skin.enabled=false",
                     "rig.clip.keys={ elbow = [[1, 0], [60, 130], [100, 130]] }"});
  Motion fast(kArm, {linear, "rig.clip.keys={ elbow = [[1, 0], [2, 0], [3, 130], [13, 130]] }"});
  slow.go_to(100);
  const FrameMeasures end = fast.go_to(13);
  EXPECT_LT(end.contact_penetration, 2e-3);
  EXPECT_LT(worst_distance(slow.state, fast.state), 2e-3);
  EXPECT_LE(end.skin.max_penetration, 1e-6);
  EXPECT_LE(end.skin.max_poke_through, 5e-4);
  EXPECT_EQ(end.skin.intersecting_pairs, 0);
}

// A skin that is a tenth too small is stretched over the flesh.
// m^2, of the cut by the plane y = `height` of a closed surface.
double section(const std::vector<Triangle>& triangles, const Points& x, double height) {
  double twice = 0.0;
  for (const Triangle& t : triangles) {
    Vec3 up = Vec3::Zero(), down = Vec3::Zero();  // where the outline enters and leaves
    int cuts = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = to_vec(x[t[k]]), b = to_vec(x[t[(k + 1) % 3]]);
      if ((a.y() > height) == (b.y() > height)) continue;
      const Vec3 at = a + (height - a.y()) / (b.y() - a.y()) * (b - a);
      (a.y() > height ? down : up) = at;
      ++cuts;
    }
    if (cuts == 2) twice += down.z() * up.x() - down.x() * up.z();
  }
  return 0.5 * std::abs(twice);
}

// A forearm that is only wrung would narrow between its ends.
TEST(ContactsOfArm, TheForearmTurnsWithoutNarrowing) {
  Motion run(kArm,
             {"rig.clip={ unit = \"deg\", keys = { forearm_rotation = [[1, 0], [31, -80]] } }"});
  const Points rest = run.state.skin.x;
  const FrameMeasures turned = run.go_to(31);
  const std::vector<Triangle>& triangles = run.model.skin.surface.triangles;
  for (double height = -0.30; height > -0.56; height -= 0.03) {
    const double before = section(triangles, rest, height);
    const double ratio = section(triangles, run.state.skin.x, height) / before;
    std::printf("at %.2f m: %.1f cm2, turned %.2f of it\n", height, 1e4 * before, ratio);
    EXPECT_GT(before, 1e-3);
    EXPECT_GT(ratio, 0.9);
    EXPECT_LT(ratio, 1.4);
  }
  EXPECT_EQ(turned.skin.intersecting_pairs, 0);
  EXPECT_LE(turned.skin.max_poke_through, 5e-4);
}

TEST_F(Contacts, ASkinThatIsATenthTooTight) {
  std::filesystem::copy(std::filesystem::path(kArm).parent_path(), folder / "arm",
                        std::filesystem::copy_options::recursive);
  std::ifstream in(folder / "arm/skin.obj");
  std::string line, tight;
  while (std::getline(in, line)) {
    double x = 0.0, y = 0.0, z = 0.0;
    if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) {
      line =
          "v " + std::to_string(0.9 * x) + " " + std::to_string(y) + " " + std::to_string(0.9 * z);
    }
    tight += line + "\n";
  }
  write("arm/skin.obj", tight);
  Motion run(folder / "arm/arm.toml", {"rig.clip.keys={ elbow = [[1, 0], [12, 120]] }"});
  for (const int frame : {2, 7, 12}) {
    const FrameMeasures measures = run.go_to(frame);
    EXPECT_LE(measures.skin.max_penetration, 1e-6) << frame;
    EXPECT_LE(measures.skin.max_poke_through, 5e-4) << frame;
    EXPECT_EQ(measures.skin.intersecting_pairs, 0) << frame;
  }
}

}  // namespace
}  // namespace thew::tests
