// SPDX-License-Identifier: Apache-2.0
//
// Shocks to the state and to the rig. After each the muscle recovers to within 1 % of the belly of
// an undisturbed run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/health.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

struct Motion {
  Model model;
  State state;
  double worst_volume = 0.0;

  explicit Motion(const std::vector<std::string>& overrides = {}) {
    model =
        build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml", overrides));
    state = initial_state(model);
    Parallel parallel(1);
    settle(model, parallel, state);
  }
  void go(int frames) {
    Parallel parallel(1);
    StageSeconds seconds;
    for (int f = 0; f < frames; ++f) {
      step_frame(model, state.time + 1.0 / model.fps, parallel, state, seconds);
      worst_volume = std::max(worst_volume, state.muscles[0].volume_error);
    }
  }
  double distance(const Motion& other) const {
    double worst = 0.0;
    for (size_t i = 0; i < state.muscles[0].x.size(); ++i) {
      worst = std::max(
          worst, (to_vec(state.muscles[0].x[i]) - to_vec(other.state.muscles[0].x[i])).norm());
    }
    return worst;
  }
  double belly() const { return model.muscles[0].shape.belly[1] - model.muscles[0].shape.belly[0]; }
};

// Moves every free node of a settled muscle and simulates one more second.
template <typename Move>
void expect_recovery(Move move) {
  Motion calm, stressed;
  for (size_t i = 0; i < stressed.state.muscles[0].x.size(); ++i) {
    if (!stressed.model.muscles[0].driven[i]) {
      stressed.state.muscles[0].x[i] = to_point(move(to_vec(stressed.state.muscles[0].x[i]), i));
    }
  }
  calm.go(24);
  stressed.go(24);
  EXPECT_LT(stressed.distance(calm), 0.01 * calm.belly());
  EXPECT_LE(stressed.state.muscles[0].volume_error, 1e-12);
}

TEST(Stress, AllNodesInAPlane) {
  expect_recovery([](Vec3 p, size_t) { return Vec3(p.x(), p.y(), 0.0); });
}

TEST(Stress, AllNodesMirrored) {
  expect_recovery([](Vec3 p, size_t) { return Vec3(p.x(), p.y(), -p.z()); });
}

TEST(Stress, AllNodesScrambled) {
  expect_recovery([](Vec3 p, size_t i) {
    const auto random = [&](size_t k) {  // a linear congruence: the same on every machine
      return ((i * 6364136223846793005ull + k * 1442695040888963407ull) >> 40) % 1000 / 1000.0 -
             0.5;
    };
    return Vec3(p + 0.1 * Vec3(random(1), random(2), random(3)));
  });
}

TEST(Stress, NodesScaledTenfold) {
  expect_recovery([](Vec3 p, size_t) { return Vec3(3.0 * p); });
}

TEST(Stress, BonesTeleport) {
  Motion run(
      {"rig.clip.keys={elbow=[[1,0],[2,130],[3,0],[24,0]]}", "rig.clip.interpolation=linear"});
  Motion calm({"rig.clip.keys={elbow=[[1,0],[24,0]]}"});
  run.go(23);
  calm.go(23);
  EXPECT_LE(run.worst_volume, 1e-12);
  EXPECT_LT(run.distance(calm), 0.01 * run.belly());
}

TEST(Stress, AFrameASecondAndTenThousand) {
  for (const char* fps : {"scene.fps=0.5", "scene.fps=10000"}) {
    Motion run({fps});
    run.go(23);
    EXPECT_LE(run.worst_volume, 1e-12) << fps;
  }
}

TEST(Stress, StiffnessOverTenDecades) {
  for (const char* stiffness : {"1e-3", "1", "1e3", "1e7"}) {
    Motion run({std::string("muscle.flexor.material.stiffness=") + stiffness});
    run.go(23);
    EXPECT_LE(run.worst_volume, 1e-12) << stiffness;
  }
}

TEST(Stress, ActivationFlickersForAThousandFrames) {
  std::string keys = "[1,0]";
  for (int f = 2; f <= 1000; ++f)
    keys += ",[" + std::to_string(f) + "," + (f % 2 ? "0" : "1") + "]";
  Motion run({"scene.frames=\"1-1100\"", "muscle.flexor.f_max=600",
              "muscle.flexor.activation=[" + keys + ",[1001,0]]",
              "rig.clip.keys={elbow=[[1,0],[1100,0]]}"});
  const Motion calm({"rig.clip.keys={elbow=[[1,0],[24,0]]}"});
  run.go(1050);
  EXPECT_LE(run.worst_volume, 1e-12);
  EXPECT_LT(run.distance(calm), 1e-5);
}

// Steps one frame, changes the state, and returns the diagnosis of that.
template <typename Harm>
StepDiagnosis found_after(Harm harm, const std::vector<std::string>& overrides = {}) {
  Motion run(overrides);
  run.go(2);
  State state = run.state;
  begin_frame(run.model, state);
  harm(run.model.muscles[0], state.muscles[0]);
  return diagnose_step(run.model, 1.0 / 24, state).value_or(StepDiagnosis{});
}

TEST(Stress, WhatIsNotANumberIsNamed) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e30}) {
    const StepDiagnosis diagnosis =
        found_after([&](const Muscle&, MuscleState& now) { now.x[40][1] = bad; });
    EXPECT_EQ(diagnosis.part, "muscle \"flexor\"") << bad;
    EXPECT_EQ(diagnosis.node, 40) << bad;
  }
}

// Each node is within the limits of position, speed and stretch; only their sum, the energy, is too
// high.
TEST(Stress, EnergyFromNowhereIsNamed) {
  const StepDiagnosis moving = found_after(
      [](const Muscle& muscle, MuscleState& now) {
        for (size_t i = 0; i < now.v.size(); ++i) {
          if (!muscle.driven[i]) now.v[i][i % 3] += i % 2 ? 6.0 : -6.0;
        }
      },
      {"muscle.flexor.material.stiffness=10"});
  EXPECT_EQ(moving.cause, Cause::kEnergy);
  EXPECT_GT(moving.value, moving.limit);
  const StepDiagnosis stretched = found_after([](const Muscle& muscle, MuscleState& now) {
    Point centre = {};
    for (const Point& x : now.x) centre += x * (1.0 / now.x.size());
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (!muscle.driven[i]) now.x[i] += 1.8 * (now.x[i] - centre);
    }
  });
  EXPECT_EQ(stretched.cause, Cause::kEnergy);
  EXPECT_EQ(stretched.part, "muscle \"flexor\"");
}

TEST(Stress, AMuscleInsideOutIsNamed) {
  for (const double error : {0.0, 2.0}) {
    const StepDiagnosis mirrored = found_after([&](const Muscle& muscle, MuscleState& now) {
      for (size_t i = 0; i < now.x.size(); ++i) {
        if (!muscle.driven[i]) now.x[i][2] = -now.x[i][2];
      }
      now.volume_error = error;
    });
    EXPECT_EQ(mirrored.cause, error > 0.0 ? Cause::kVolume : Cause::kTurnedOver);
    EXPECT_EQ(mirrored.part, "muscle \"flexor\"");
  }
}

}  // namespace
}  // namespace thew::tests
