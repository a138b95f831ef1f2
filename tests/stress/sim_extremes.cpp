// SPDX-License-Identifier: Apache-2.0
//
// Extreme bodies, meshes, weights and motions. Each run recovers or is refused with an error that
// names the muscle. No result has a number that is not finite.
#include <gtest/gtest.h>

#include <cmath>

#include "muscles/volume.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/distance.h"

namespace thew::tests {
namespace {

const std::string kOneMuscle = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml";
const std::string kPaper = THEW_SOURCE_DIR "/assets/paper/";

struct Motion {
  Model model;
  State state;
  std::string refusal;        // what the solver said
  double worst_volume = 0.0;  // of all frames

  explicit Motion(const std::string& scene, const std::vector<std::string>& overrides = {})
      : model(build_model(read_scene(scene, overrides))), state(initial_state(model)) {}

  void settle_first() {
    Parallel one(1);
    settle(model, one, state);
  }
  void go(int frames) {
    Parallel one(1);
    StageSeconds seconds;
    try {
      for (int f = 0; f < frames; ++f) {
        step_frame(model, state.time + 1.0 / model.fps, one, state, seconds);
        for (int m = 0; m < state.count(); ++m) {
          for (const Point& x : state.muscles[m].x) ASSERT_TRUE(to_vec(x).allFinite());
          worst_volume = std::max(worst_volume, volume_error(m));
        }
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kSolver);
      refusal = error.what();
    }
  }
  double volume_error(int m = 0) const {
    const Muscle& muscle = model.muscles[m];
    return std::abs(
        enclosed_volume(state.muscles[m].x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
  }
  bool refused_by_name() const {
    return refusal.find("muscle \"" + model.muscles[0].name + "\"") != std::string::npos;
  }
};

double worst_distance(const Motion& a, const Motion& b) {
  return tests::worst_distance(a.state, b.state);
}

// Moves every free node of a settled muscle and lets it go for a second: back within 1 % of the
// belly, by each implicit integrator.
template <typename Move>
void expect_recovery(Move move) {
  for (const char* integrator : {"local_global", "quasi_static"}) {
    const std::vector<std::string> overrides = {std::string("solver.integrator=") + integrator};
    Motion calm(kOneMuscle, overrides), stressed(kOneMuscle, overrides);
    calm.settle_first();
    stressed.settle_first();
    Points& x = stressed.state.muscles[0].x;
    for (size_t i = 0; i < x.size(); ++i) {
      if (!stressed.model.muscles[0].driven[i]) x[i] = to_point(move(to_vec(x[i])));
    }
    calm.go(24);
    stressed.go(24);
    EXPECT_EQ(stressed.refusal, "") << integrator;
    EXPECT_LT(worst_distance(calm, stressed), 0.0018) << integrator;
    EXPECT_LE(stressed.volume_error(), 1e-12) << integrator;
  }
}

const Vec3 kBelly(0.03, -0.19, 0.0);  // its middle, m

TEST(Extremes, AllNodesInAPoint) {
  expect_recovery([](const Vec3&) { return kBelly; });
}

TEST(Extremes, AllNodesOnALine) {
  expect_recovery([](const Vec3& p) { return Vec3(kBelly.x(), p.y(), 0.0); });
}

TEST(Extremes, InsideOut) {
  expect_recovery([](const Vec3& p) { return Vec3(2.0 * kBelly - p); });
}

TEST(Extremes, ThreeTurnsLetGo) {
  expect_recovery([](const Vec3& p) {
    const double angle = 6.0 * M_PI * (p.y() + 0.25) / 0.12;
    const double c = std::cos(angle), s = std::sin(angle);
    const double x = p.x() - kBelly.x();
    return Vec3(kBelly.x() + c * x - s * p.z(), p.y(), s * x + c * p.z());
  });
}

TEST(Extremes, StretchedFivefoldAndScaledAThousandTimes) {
  expect_recovery([](const Vec3& p) { return Vec3(kBelly + 5.0 * (p - kBelly)); });
  expect_recovery([](const Vec3& p) { return Vec3(kBelly + 1e-3 * (p - kBelly)); });
}

TEST(Extremes, AStepOfAFifthOfASecond) {
  for (const char* stiffness : {"1e-2", "1e3", "1e8"}) {
    Motion run(kOneMuscle,
               {"scene.fps=5", std::string("muscle.flexor.material.stiffness=") + stiffness});
    run.settle_first();
    run.go(23);
    EXPECT_EQ(run.refusal, "") << stiffness;
    EXPECT_LE(run.worst_volume, 1e-12) << stiffness;
  }
}

TEST(Extremes, MassesThatDifferByAMillion) {
  Motion run(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
             {"skin.enabled=false", "scene.gravity=[0,0,0]", "muscle.front.material.density=1e6",
              "muscle.side.material.density=1"});
  run.settle_first();
  run.go(15);
  EXPECT_EQ(run.refusal, "");
  EXPECT_LE(run.worst_volume, 1e-12);
}

TEST(Extremes, PlanesThatSqueezeToOnePercent) {
  for (const char* integrator : {"local_global", "explicit"}) {
    Motion run(
        kPaper + "ball.toml",
        {"muscle.ball.mesh=ball_1470.obj", std::string("solver.integrator=") + integrator,
         "rig.clip.keys={top=[[1,0],[31,0.0495],[61,0.09]],bottom=[[1,0],[31,0.0495],[61,0.09]]}"});
    run.go(61);
    if (run.refusal.empty()) {
      EXPECT_LE(run.worst_volume, 1e-12) << integrator;
    } else {
      EXPECT_TRUE(run.refused_by_name()) << run.refusal;
    }
  }
}

// A body is fixed on four sides and pressed on the other two, so that no motion of the free nodes
// restores the volume.
TEST(Extremes, AVolumeThatNoMotionReaches) {
  const std::string walls =
      "muscle.cube.fixed=[{body=\"bottom\",high=[-0.0999,1,1]},{body=\"bottom\",low=[0.0999,-1,-1]}"
      ","
      "{body=\"bottom\",high=[1,1,-0.0999]},{body=\"bottom\",low=[-1,-1,0.0999]}]";
  Motion run(kPaper + "cube_twist.toml",
             {"rig.clip.keys={twist=[[1,0]]}", "solver.integrator=local_global", walls});
  Muscle& cube = run.model.muscles[0];
  const double volume = cube.rest_volume;
  cube.rest_volume = -1e3 * volume;  // inside out, a thousandfold
  const State before = run.state;
  run.go(5);
  if (run.refusal.empty()) {
    EXPECT_GT(run.state.muscles[0].unreached + (run.worst_volume <= 1e-12), 0);
  } else {
    EXPECT_TRUE(run.refused_by_name()) << run.refusal;
  }
  cube.rest_volume = volume;
  run.state = before;
  run.refusal.clear();
  run.go(30);
  EXPECT_EQ(run.refusal, "");
  EXPECT_LE(run.volume_error(), 1e-12);
}

class ExtremeScene : public TempFolder {
 protected:
  // One muscle, `scale` times as large, bent by 60 degrees.
  std::filesystem::path scaled(double scale) const {
    const auto metres = [&](double x) { return std::to_string(scale * x); };
    write("rig.urdf",
          "<robot name=\"r\"><link name=\"humerus\"/><link name=\"ulna\"/><joint name=\"elbow\" "
          "type=\"revolute\"><parent link=\"humerus\"/><child link=\"ulna\"/><origin xyz=\"0 -" +
              metres(0.3) +
              " 0\"/><axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"2.4\" effort=\"1\" "
              "velocity=\"1\"/></joint></robot>");
    return write(
        "scene.toml",
        "[scene]\nfps = 24\nframes = \"1-24\"\ngravity = [0, 0, 0]\n[rig]\nfile = \"rig.urdf\"\n"
        "[rig.clip]\nunit = \"deg\"\nkeys = { elbow = [[1, 0], [24, 60]] }\n[[muscle]]\nname = "
        "\"flexor\"\npath = [[\"humerus\", " +
            metres(0.03) + ", -" + metres(0.03) + ", 0], [\"ulna\", " + metres(0.03) + ", -" +
            metres(0.05) + ", 0]]\nbelly = [" + metres(0.06) + ", " + metres(0.24) +
            "]\nweights = \"left\"\nprofile = { around = 12, rings = 11, radius = [[0, " +
            metres(0.004) + "], [0.5, " + metres(0.018) + "], [1, " + metres(0.004) + "]] }\n");
  }
  // A soft body of the given OBJ between the paper's planes, which squeeze a height of 0.2 m.
  std::filesystem::path soft(const std::string& obj, const std::string& more = "") const {
    for (const char* name : {"press.urdf", "box.obj"}) {
      std::filesystem::copy_file(kPaper + name, folder / name);
    }
    write("body.obj", obj);
    return write("scene.toml",
                 "[scene]\nfps = 30\nframes = \"1-61\"\nsettle = 0\ngravity = [0, 0, 0]\n[rig]\n"
                 "file = \"press.urdf\"\n[rig.clip]\nkeys = { top = [[1, 0], [31, 0.05], [61, "
                 "-0.02]], bottom = [[1, 0], [31, 0.05], [61, -0.02]] }\n[contact]\nmargin = 0.03\n"
                 "gap = 0\nmax_depth = 0.03\n[[muscle]]\nname = \"body\"\nmesh = \"body.obj\"\n"
                 "damping = 5\nmaterial = { anisotropy = 1 }\n" +
                     more);
  }
};

TEST_F(ExtremeScene, AHundredTimesTheSize) {
  Motion one(scaled(1.0)), large(scaled(100.0));
  for (Motion* run : {&one, &large}) {
    run->settle_first();
    run->go(23);
    EXPECT_EQ(run->refusal, "");
    EXPECT_LE(run->worst_volume, 1e-12);
  }
  double worst = 0.0;  // m, at the small one's size
  for (size_t i = 0; i < one.state.muscles[0].x.size(); ++i) {
    worst = std::max(
        worst,
        (to_vec(one.state.muscles[0].x[i]) - 0.01 * to_vec(large.state.muscles[0].x[i])).norm());
  }
  EXPECT_LT(worst, 0.0018);
}

const std::string kOctahedron =
    "v 0.1 0 0\nv -0.1 0 0\nv 0 0.1 0\nv 0 -0.1 0\nv 0 0 0.1\nv 0 0 -0.1\nf 1 3 5\nf 3 2 5\n"
    "f 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

TEST_F(ExtremeScene, AMuscleOfEightTriangles) {
  for (const char* integrator : {"local_global", "xpbd", "explicit"}) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    Motion run(soft(kOctahedron), {std::string("solver.integrator=") + integrator});
    run.go(60);
    EXPECT_EQ(run.refusal, "") << integrator;
    EXPECT_LE(run.worst_volume, 1e-12) << integrator;
  }
}

TEST(Extremes, AMuscleOfTwoHundredThousandTriangles) {
#ifdef THEW_SANITIZED
  const char *around = "80", *rings = "124";  // a tenth
#else
  const char *around = "250", *rings = "398";
#endif
  Motion run(kOneMuscle, {std::string("muscle.flexor.profile.around=") + around,
                          std::string("muscle.flexor.profile.rings=") + rings});
  run.go(2);
  EXPECT_EQ(run.refusal, "");
  EXPECT_LE(run.worst_volume, 1e-12);
}

// The edge 1-3 has a node on it, and a triangle without area closes the gap.
TEST_F(ExtremeScene, ATriangleWithoutArea) {
  std::string obj = kOctahedron;
  obj.replace(obj.find("f 1 3 5"), 7, "v 0.05 0.05 0\nf 1 7 5\nf 7 3 5\nf 1 3 7");
  try {
    Motion run(soft(obj));
    run.go(60);
    EXPECT_EQ(run.refusal, "");
    EXPECT_LE(run.worst_volume, 1e-12);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_NE(std::string(error.what()).find("body.obj"), std::string::npos) << error.what();
  }
}

// The whole volume correction on a few nodes tore them out of the surface. The floor under the
// weights prevents that, with a warning.
TEST_F(ExtremeScene, WeightsOnAFewNodes) {
  const size_t nodes = Motion(kPaper + "ball.toml", {"muscle.ball.mesh=ball_1470.obj"})
                           .model.muscles[0]
                           .rest.vertices.size();
  for (const size_t count : {1, 10, 30, 100}) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    std::string weights;
    for (size_t i = 0; i < nodes; ++i) weights += i < count ? "1\n" : "0\n";
    write("weights.txt", weights);
    std::filesystem::copy_file(kPaper + "ball_1470.obj", folder / "ball.obj");
    const auto scene = soft(kOctahedron, "weights = { file = \"weights.txt\" }\n");
    Motion run(scene, {"muscle.body.mesh=ball.obj"});
    ASSERT_EQ(run.model.warnings.size(), 1u);
    EXPECT_NE(run.model.warnings[0].find("too few nodes"), std::string::npos);
    run.go(60);
    EXPECT_EQ(run.refusal, "") << count;
    EXPECT_LE(run.worst_volume, 1e-12) << count;
  }
}

}  // namespace
}  // namespace thew::tests
