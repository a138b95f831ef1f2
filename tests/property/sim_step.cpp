// SPDX-License-Identifier: Apache-2.0
//
// Facts of the step that hold for any scene, shown on one muscle.
#include <gtest/gtest.h>

#include <algorithm>

#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/distance.h"

namespace thew::tests {
namespace {

struct Motion {
  Model model;
  State state;
  double worst_volume = 0.0, worst_substep = 0.0;
};

Motion simulate(const std::vector<std::string>& overrides, int frames = 24, int threads = 1) {
  Motion out;
  out.model =
      build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml", overrides));
  out.model.solver.rungs = false;
  Parallel parallel(threads);
  out.state = initial_state(out.model);
  settle(out.model, parallel, out.state);
  StageSeconds seconds;
  for (int f = 1; f < frames; ++f) {
    step_frame(out.model, f / out.model.fps, parallel, out.state, seconds);
    out.worst_volume = std::max(out.worst_volume, out.state.muscles[0].volume_error);
    out.worst_substep = std::max(out.worst_substep, out.state.muscles[0].substep_volume_error);
  }
  return out;
}

double worst_distance(const Motion& a, const Motion& b) {
  return tests::worst_distance(a.state, b.state);
}

TEST(Step, ExactMultiplierHoldsTheVolumeInEveryStep) {
  const Motion exact = simulate({});
  EXPECT_LE(exact.worst_substep, 1e-12);
  const Motion linear = simulate({"solver.volume=linear"});
  EXPECT_GT(linear.worst_volume, 1e-12);
  const Motion none = simulate({"solver.volume=none"});
  EXPECT_GT(none.worst_volume, linear.worst_volume);
}

TEST(Step, ExplicitHoldsItAtTheFramesEnds) {
  const Motion exact = simulate({"solver.integrator=explicit"});
  EXPECT_LE(exact.worst_volume, 1e-12);
  EXPECT_LE(exact.worst_substep, 1e-5);
}

TEST(Step, BothIntegratorsEndInTheSameShape) {
  EXPECT_LT(
      worst_distance(simulate({"solver.integrator=explicit"}), simulate({"solver.substeps=4"})),
      5e-4);
}

TEST(Step, RefinementConverges) {
  const Motion fine = simulate({"solver.substeps=32", "solver.iterations=30"});
  const double coarse = worst_distance(simulate({}), fine);
  EXPECT_LT(coarse, 5e-4);
  EXPECT_LT(worst_distance(simulate({"solver.substeps=8", "solver.iterations=30"}), fine),
            std::max(0.5 * coarse, 1e-6));
}

TEST(Step, ThePrintedMultiplierDivergesOnBellyWeights) {
  const std::string belly = "muscle.flexor.weights={profile=[[0.15,0.05],[0.5,1],[0.85,0.05]]}";
  const Motion mended = simulate({belly, "solver.volume=linear", "solver.integrator=explicit"}, 3);
  EXPECT_LT(mended.worst_substep, 1e-4);
  try {
    const Motion printed =
        simulate({belly, "solver.volume=printed", "solver.integrator=explicit"}, 3);
    EXPECT_GT(printed.worst_substep, 0.01);
  } catch (const Error& error) {  // it diverged so far that the step was refused
    EXPECT_EQ(error.code(), ErrorCode::kSolver);
  }
}

TEST(Step, WeightsScaledAlikeGiveTheSameMotion) {
  const Motion once = simulate({"muscle.flexor.weights={profile=[[0,0.5],[1,1]]}"});
  const Motion thrice = simulate({"muscle.flexor.weights={profile=[[0,1.5],[1,3]]}"});
  EXPECT_LT(worst_distance(once, thrice), 1e-12);
}

TEST(Step, TheStateRoundTripsToTheBit) {
  Motion whole = simulate({}, 12);
  State resumed;
  unpack_state(whole.model, pack_state(whole.state), resumed);
  Parallel parallel(1);
  StageSeconds seconds;
  for (State* state : {&whole.state, &resumed}) {
    for (int f = 12; f < 16; ++f) step_frame(whole.model, f / 24.0, parallel, *state, seconds);
  }
  for (size_t i = 0; i < resumed.muscles[0].x.size(); ++i) {
    EXPECT_EQ(to_vec(resumed.muscles[0].x[i]), to_vec(whole.state.muscles[0].x[i]));
  }
}

TEST(Step, ActivationTightensTheFibres) {
  const std::vector<std::string> active = {"muscle.flexor.f_max=600",
                                           "muscle.flexor.activation=[[1,1],[24,1]]"};
  const Motion rest = simulate({}, 2), tense = simulate(active, 2);
  const Springs& springs = rest.model.muscles[0].springs;
  double shorter = 0.0;
  for (int k = 0; k < springs.structural; ++k) {
    const double change =
        tense.state.muscles[0].rest_length[k] - rest.state.muscles[0].rest_length[k];
    EXPECT_LE(change, 0.0);
    shorter += change;
  }
  EXPECT_LT(shorter, -1e-5);
  EXPECT_LE(tense.worst_volume, 1e-12);
}

TEST(Step, WeightsAloneShapeTheBellyToo) {
  const Motion alone = simulate({"muscle.flexor.shape=weights"});
  EXPECT_LE(alone.worst_volume, 1e-12);
  EXPECT_GT(worst_distance(
                alone, simulate({"muscle.flexor.shape=weights", "muscle.flexor.weights=right"})),
            1e-4);
}

}  // namespace
}  // namespace thew::tests
