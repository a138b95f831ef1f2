// SPDX-License-Identifier: Apache-2.0
//
// solver.tolerance: which levels are chosen, and that they keep the tolerance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/bake/bake.h"
#include "sim/fidelity/planner.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

using Settings = std::vector<std::string>;

Model model_of(const std::string& scene, Settings overrides, double tolerance) {
  overrides.push_back("skin.enabled=false");
  if (scene != "pair") overrides.pop_back();
  Scene read = read_scene(THEW_SOURCE_DIR "/tests/scenes/" + scene + "/scene.toml", overrides);
  if (tolerance > 0.0) {
    read.solver.tolerance.emplace();
    read.solver.tolerance->position = tolerance;
    read.solver.tolerance->location = "here";
  }
  return build_model(read);
}

struct Motion {
  std::vector<std::vector<Points>> x;  // by frame and muscle
  double volume_error = 0.0;
};

Motion simulate(const Model& model) {
  Motion motion;
  Parallel one(1);
  StageSeconds unused;
  State state = initial_state(model);
  settle(model, one, state);
  for (int f = model.first_frame; f <= model.last_frame; ++f) {
    const double time = (f - model.first_frame) / model.fps;
    if (f > model.first_frame) step_frame(model, time, one, state, unused);
    std::vector<Points>& rows = motion.x.emplace_back();
    for (int m = 0; m < state.count(); ++m) {
      rows.push_back(state.muscles[m].x);
      const Muscle& muscle = model.muscles[m];
      const double volume = enclosed_volume(rows.back(), muscle.rest.triangles);
      motion.volume_error =
          std::max(motion.volume_error, std::abs(volume / muscle.rest_volume - 1.0));
    }
  }
  return motion;
}

// The plan, and the largest errors of all muscles: in all frames, and in those that were neither
// probed nor checked.
struct Outcome {
  FidelityPlan plan;
  double error = 0.0, unseen_error = 0.0, volume_error = 0.0;
  int unseen = 0;
};
Outcome outcome_of(const std::string& scene, const Settings& overrides, double tolerance) {
  Outcome out;
  Model model = model_of(scene, overrides, tolerance);
  out.plan = plan_fidelity(model, 1);
  model.fidelity = out.plan.fidelity;
  const Motion chosen = simulate(model);
  Settings fine = overrides;
  fine.insert(fine.end(), {"solver.substeps=8", "solver.iterations=40"});
  const Motion reference = simulate(model_of(scene, fine, 0.0));
  std::vector<int> seen = out.plan.probed;
  seen.insert(seen.end(), out.plan.checked.begin(), out.plan.checked.end());
  for (size_t f = 0; f < reference.x.size(); ++f) {
    const int number = model.first_frame + static_cast<int>(f);
    const bool unseen = std::find(seen.begin(), seen.end(), number) == seen.end();
    out.unseen += unseen;
    for (size_t m = 0; m < reference.x[f].size(); ++m) {
      const double error = largest_distance(chosen.x[f][m], reference.x[f][m]);
      out.error = std::max(out.error, error);
      if (unseen) out.unseen_error = std::max(out.unseen_error, error);
    }
  }
  out.volume_error = chosen.volume_error;
  return out;
}

TEST(Fidelity, ALoneMuscleIsCarriedWithoutForces) {
  const Outcome out = outcome_of("one_muscle", {}, 5e-4);
  ASSERT_EQ(out.plan.muscles.size(), 1u);
  EXPECT_EQ(out.plan.muscles[0].level, Level::kGeometric);
  EXPECT_LE(out.error, 5e-4);
  EXPECT_GT(out.error, 0.0);
  EXPECT_LE(out.volume_error, 1e-12);
  EXPECT_LT(out.plan.work, out.plan.uniform_work);
  EXPECT_TRUE(out.plan.raised.empty());
}

// A clip that is too long to be refined as a whole: most frames are neither probed nor checked.
TEST(Fidelity, ALongClipIsKeptBetweenItsProbes) {
  const Settings swing = {"scene.frames=1-160",
                          "rig.clip.keys={ elbow = [[1, 0], [40, 90], [90, 10], [160, 70]] }"};
  const Outcome out = outcome_of("one_muscle", swing, 3e-4);
  EXPECT_GT(out.unseen, 120);
  EXPECT_GT(out.unseen_error, 0.0);
  EXPECT_LE(out.unseen_error, 3e-4);
  EXPECT_LE(out.error, 3e-4);
  EXPECT_LE(out.volume_error, 1e-12);
}

TEST(Fidelity, AMuscleThatJigglesIsDynamic) {
  const Settings soft = {"rig.clip.keys={ elbow = [[1, 0], [8, 60], [24, 60]] }",
                         "muscle.flexor.material={ stiffness = 100, shape = 0.3 }",
                         "muscle.flexor.damping=2"};
  const Outcome out = outcome_of("one_muscle", soft, 4e-4);
  EXPECT_EQ(out.plan.muscles[0].level, Level::kDynamic) << out.plan.muscles[0].reason;
  EXPECT_LE(out.error, 4e-4);
  EXPECT_LE(out.volume_error, 1e-12);
}

TEST(Fidelity, WhatNothingMovesSleeps) {
  const Outcome out =
      outcome_of("one_muscle", {"rig.clip.keys={ elbow = [[1, 30], [24, 30]] }"}, 1e-4);
  EXPECT_EQ(out.plan.muscles[0].level, Level::kAsleep);
  EXPECT_EQ(out.plan.work, 0.0);
  EXPECT_LE(out.error, 1e-4);
  EXPECT_LE(out.volume_error, 1e-12);
}

// A muscle that is moved by a press alone; its own path does not move.
TEST(Fidelity, WhatIsTouchedIsAwake) {
  const Outcome out = outcome_of("pressed", {}, 2e-3);
  EXPECT_NE(out.plan.muscles[0].level, Level::kAsleep);
  EXPECT_LE(out.error, 2e-3);
  EXPECT_LE(out.volume_error, 1e-12);
}

// Two ridges that slip past each other. With half of the refined step's substeps they differ by
// 0.36 mm.
TEST(Fidelity, MusclesThatPressOnEachOther) {
  const Outcome out = outcome_of("pair", {}, 1e-3);
  EXPECT_LE(out.error, 1e-3);
  for (const ChosenMuscle& muscle : out.plan.muscles) {
    const double error = std::max(muscle.probed_error, muscle.checked_error);
    EXPECT_GT(muscle.refined_error, 1e-4);
    EXPECT_LE(error + muscle.refined_error, 1e-3);
  }
  EXPECT_LE(out.volume_error, 1e-12);
  for (const ChosenMuscle& muscle : out.plan.muscles) EXPECT_FALSE(muscle.reason.empty());
}

std::string refusal(const std::string& scene, double tolerance) {
  try {
    plan_fidelity(model_of(scene, {}, tolerance), 1);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
  return "";
}

TEST(Fidelity, WhatCannotBeKeptIsRefused) {
  for (const std::string& message : {refusal("pressed", 1e-6), refusal("pair", 5e-4)}) {
    EXPECT_EQ(message.substr(0, 24), "here: solver.tolerance: ") << message;
    EXPECT_NE(message.find("give a larger tolerance"), std::string::npos) << message;
  }
  const std::string unknown = refusal("pressed", 1e-6);
  EXPECT_NE(unknown.find("the refined step itself is known to "), std::string::npos) << unknown;
}

class FidelityBake : public TempFolder {
 protected:
  BakeResult run(const std::string& name, int threads, bool resume = false, int stop_at = 100) {
    return bake(model_of("pair", {}, 1e-3),
                {folder / name, {1, 2, 3, 4, 5, 6, 7, 8}, threads, resume},
                [&](const BakeFrame& frame) { return frame.frame < stop_at; });
  }
};

TEST_F(FidelityBake, TheSameForAnyNumberOfThreadsAndResumedOrNot) {
  const BakeResult whole = run("one", 1);
  ASSERT_TRUE(whole.plan);
  EXPECT_EQ(whole.hash, run("two", 2).hash);
  for (const int frames : {1, 4}) {
    EXPECT_THROW(run("cut", 1, false, frames), Error);
    const BakeResult resumed = run("cut", 2, true);
    EXPECT_EQ(resumed.resumed_frames, frames);
    EXPECT_EQ(whole.hash, resumed.hash);
    std::filesystem::remove_all(folder / "cut");
  }
}

}  // namespace
}  // namespace thew::tests
