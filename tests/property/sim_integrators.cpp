// SPDX-License-Identifier: Apache-2.0
//
// The four integrators solve one model: forces balance at rest, and all end in the same shape, for
// any number of substeps and iterations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/muscles/shapes.h"
#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/distance.h"

namespace thew::tests {
namespace {

struct Motion {
  Model model;
  State state;

  Motion(const std::string& scene, const std::vector<std::string>& overrides) {
    model = build_model(read_scene(THEW_SOURCE_DIR + scene, overrides));
    state = initial_state(model);
  }
  void settle_first() {
    Parallel one(1);
    settle(model, one, state);
  }
  void go_to(int frame, int threads = 1) {
    Parallel parallel(threads);
    StageSeconds seconds;
    const int first = model.first_frame;
    const int now = first + static_cast<int>(std::lround(state.time * model.fps));
    for (int f = now + 1; f <= frame; ++f) {
      step_frame(model, (f - first) / model.fps, parallel, state, seconds);
    }
  }
};

double worst_distance(const Motion& a, const Motion& b) {
  return tests::worst_distance(a.state, b.state);
}

const std::string kOneMuscle = "/tests/scenes/one_muscle/scene.toml";

// The paper's cube, hung by its bottom from a ceiling, under its own weight.
std::vector<std::string> hanging(const std::vector<std::string>& more) {
  std::vector<std::string> overrides = {
      "scene.gravity=[0,9.81,0]", "rig.clip.keys={twist=[[1,0],[600,0]]}", "scene.frames=\"1-600\"",
      "muscle.cube.fixed=[{body=\"bottom\",high=[1,-0.0999,1]}]"};
  overrides.insert(overrides.end(), more.begin(), more.end());
  return overrides;
}
const std::string kCube = "/assets/paper/cube_twist.toml";

double hung_length(const Motion& cube) {
  double low = 1.0, high = -1.0;
  for (const Point& x : cube.state.muscles[0].x) {
    low = std::min(low, x[1]);
    high = std::max(high, x[1]);
  }
  return high - low;
}

// Net force of the springs on a muscle's nodes.
Points spring_forces(const Motion& motion) {
  const MuscleState& now = motion.state.muscles[0];
  Points f(now.x.size(), Point{});
  add_spring_forces(motion.model.muscles[0].springs, now.rest_length, now.x, f);
  return f;
}

TEST(QuasiStatic, BalancesTheWeightOfAHangingCube) {
  Motion cube(kCube, hanging({"solver.integrator=quasi_static", "solver.volume=none"}));
  cube.go_to(2);
  const Muscle& muscle = cube.model.muscles[0];
  const Points f = spring_forces(cube);
  double weight = 0.0, held = 0.0, loose = 0.0;
  for (size_t i = 0; i < f.size(); ++i) {
    const Vec3 gravity = muscle.mass[i] * cube.model.gravity;
    if (muscle.driven[i]) {
      held += f[i][1];
      continue;
    }
    weight += gravity.y();
    loose = std::max(loose, (to_vec(f[i]) + gravity).norm());
  }
  EXPECT_NEAR(held, weight, 1e-6 * weight);  // the ceiling carries all of it
  EXPECT_LT(loose, 1e-6 * weight);
  EXPECT_GT(hung_length(cube), 0.25);
}

// The cube begins at rest in the shape that quasi_static ends in and has to keep it. An integrator
// that is softer or stiffer than the springs would let it sink or rise.
TEST(Integrators, HangACubeAlike) {
  Motion still(kCube, hanging({"solver.integrator=quasi_static"}));
  still.go_to(2);
  const double truth = hung_length(still) - 0.2;
  EXPECT_GT(truth, 0.05);
  for (const auto& [integrator, substeps, iterations] :
       {std::array{"local_global", "1", "10"}, std::array{"explicit", "1", "1"},
        std::array{"xpbd", "4", "40"}, std::array{"xpbd", "64", "3"}}) {
    Motion cube(kCube, hanging({std::string("solver.integrator=") + integrator,
                                std::string("solver.substeps=") + substeps,
                                std::string("solver.iterations=") + iterations}));
    cube.state = still.state;
    cube.state.muscles[0].v.assign(cube.state.muscles[0].v.size(), Point{});
    cube.go_to(22);
    EXPECT_NEAR(hung_length(cube) - 0.2, truth, 0.01 * truth) << integrator << " " << substeps;
    EXPECT_LT(worst_distance(cube, still), 1e-3) << integrator << " " << substeps;
  }
}

TEST(QuasiStatic, IsTheRestOfTheMotionAndKnowsNoFrameBefore) {
  const std::string longer = "scene.frames=\"1-96\"";
  Motion still(kOneMuscle, {longer, "solver.integrator=quasi_static"});
  Motion straight(kOneMuscle,
                  {longer, "solver.integrator=quasi_static", "rig.clip.keys={elbow=[[1,60]]}"});
  Motion moving(kOneMuscle, {longer, "solver.iterations=10"});
  still.settle_first();
  moving.settle_first();
  still.go_to(24);
  moving.go_to(24);
  EXPECT_GT(worst_distance(still, moving), 1e-7);
  moving.go_to(96);
  EXPECT_LT(worst_distance(still, moving), 1e-8);
  straight.settle_first();
  straight.go_to(2);
  EXPECT_LT(worst_distance(still, straight), 1e-6);
  EXPECT_LE(still.state.muscles[0].volume_error, 1e-12);
}

// Area of the middle section over that at rest, minus 1.
double bulge(const Motion& motion) {
  const Muscle& muscle = motion.model.muscles[0];
  const double area =
      section_area_at(muscle, motion.state.muscles[0].pose, motion.state.muscles[0].x, 0.4);
  const Motion rest(kOneMuscle, {});
  return area / section_area_at(muscle, rest.state.muscles[0].pose, rest.state.muscles[0].x, 0.4) -
         1.0;
}

TEST(Xpbd, StiffnessDoesNotDependOnTheCounts) {
  Motion still(kOneMuscle, {"solver.integrator=quasi_static"});
  still.settle_first();
  still.go_to(24);
  const double truth = bulge(still);
  EXPECT_GT(truth, 0.5);
  for (const char* substeps : {"4", "16", "64"}) {
    for (const char* iterations : {"4", "16"}) {
      Motion run(kOneMuscle, {"solver.integrator=xpbd", std::string("solver.substeps=") + substeps,
                              std::string("solver.iterations=") + iterations});
      run.settle_first();
      run.go_to(24);
      EXPECT_NEAR(bulge(run), truth, 0.01 * truth) << substeps << " x " << iterations;
    }
  }
}

// Where the residual is 0.05 mm or less, the bulge is the one of balanced forces, for any number of
// substeps and iterations. Shaped by the weights alone and of soft material, which takes the most
// iterations.
TEST(LocalGlobal, StiffnessDoesNotDependOnTheCountsAtItsResidual) {
  const std::vector<std::string> soft = {"muscle.flexor.shape=weights",
                                         "muscle.flexor.material={ shape = 0.3 }"};
  const auto run_with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> overrides = soft;
    overrides.insert(overrides.end(), more.begin(), more.end());
    Motion run(kOneMuscle, overrides);
    run.settle_first();
    run.go_to(24);
    return run;
  };
  const double truth = bulge(run_with({"solver.integrator=quasi_static"}));
  int within = 0;
  for (const char* substeps : {"1", "2", "8"}) {
    for (const char* iterations : {"1", "2", "5", "10", "20", "40"}) {
      const Motion run = run_with({std::string("solver.substeps=") + substeps,
                                   std::string("solver.iterations=") + iterations});
      const double residual = 1e3 * run.state.muscles[0].residual;
      std::printf("%s x %s: residual %.2g mm, bulge %.5f of %.5f\n", substeps, iterations, residual,
                  bulge(run), truth);
      if (residual > 0.05) continue;
      ++within;
      EXPECT_NEAR(bulge(run), truth, 0.01 * truth) << substeps << " x " << iterations;
    }
  }
  EXPECT_GE(within, 6);
}

// A muscle whose triangles are cut in 4 and in 16: the same surface, four and sixteen times the
// springs. Shaped by the weights alone and of soft material, where the springs matter most.
class Subdivided : public TempFolder {
 protected:
  double bulge_of(const TriMesh& mesh, const std::string& integrator, const std::string& shape) {
    std::string obj;
    for (const Vec3& p : mesh.vertices) {
      char line[100];
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
      obj += line;
    }
    for (const auto& [a, b, c] : mesh.triangles) {
      obj += "f " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
             std::to_string(c + 1) + "\n";
    }
    write("muscle.obj", obj);
    const std::string from = THEW_SOURCE_DIR + kOneMuscle;
    std::filesystem::copy_file(std::filesystem::path(from).parent_path() / "rig.urdf",
                               folder / "rig.urdf",
                               std::filesystem::copy_options::overwrite_existing);
    std::ifstream in(from);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const size_t profile = text.find("[muscle.profile]"), output = text.find("[output]");
    text.replace(profile, output - profile,
                 "mesh = \"muscle.obj\"\nshape = \"" + shape + "\"\nmaterial = { shape = 0.3 }\n");
    const auto scene = write("scene.toml", text);
    Model model =
        build_model(read_scene(scene, {"solver.integrator=" + integrator, "solver.iterations=40"}));
    State state = initial_state(model);
    Parallel one(1);
    StageSeconds seconds;
    const double rest =
        mean_belly_area(model.muscles[0], state.muscles[0].pose, state.muscles[0].x);
    settle(model, one, state);
    for (int f = 1; f < 24; ++f) step_frame(model, f / model.fps, one, state, seconds);
    EXPECT_LE(state.muscles[0].volume_error, 1e-12);
    return section_area_at(model.muscles[0], state.muscles[0].pose, state.muscles[0].x, 0.4) / rest;
  }
};

TEST_F(Subdivided, MovesTheBulgeByLessThanTwoPercent) {
  const TriMesh coarse = build_model(read_scene(THEW_SOURCE_DIR + kOneMuscle)).muscles[0].rest;
  const TriMesh four = subdivided(coarse);
  for (const char* integrator : {"local_global", "quasi_static"}) {
    for (const char* shape : {"target", "weights"}) {
      const double truth = bulge_of(coarse, integrator, shape);
      EXPECT_GT(truth, 1.2);
      EXPECT_NEAR(bulge_of(four, integrator, shape), truth, 0.02 * truth) << integrator << shape;
      EXPECT_NEAR(bulge_of(subdivided(four), integrator, shape), truth, 0.02 * truth)
          << integrator << shape;
    }
  }
}

TEST(Xpbd, HasTheSameBytesForAnyNumberOfThreads) {
  const std::string pair = "/tests/scenes/pair/scene.toml";
  const std::vector<std::string> overrides = {"solver.integrator=xpbd", "solver.substeps=4",
                                              "skin.enabled=false"};
  Motion one(pair, overrides), three(pair, overrides);
  one.go_to(4, 1);
  three.go_to(4, 3);
  EXPECT_EQ(pack_state(one.state), pack_state(three.state));
}

}  // namespace
}  // namespace thew::tests
