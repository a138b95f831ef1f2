// SPDX-License-Identifier: Apache-2.0
// Faults inside a substep. The linker puts this file's function between the step and its health
// check (CMakeLists.txt), so that no code of Thew knows of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sim/health.h"
#include "sim/step.h"

namespace thew {
// By the linker's names: the check itself, and what is called in its place.
std::string true_find_trouble(const Model& model, double h, const State& state) __asm__(
    "__real__ZN4thew12find_troubleB5cxx11ERKNS_5ModelEdRKNS_5StateE");
std::string find_trouble_after_fault(const Model& model, double h, const State& state) __asm__(
    "__wrap__ZN4thew12find_troubleB5cxx11ERKNS_5ModelEdRKNS_5StateE");

namespace {

/// What befalls the substep number `at`, counted from 0.
struct Fault {
  int at = -1;
  int muscle = 0, node = 0, component = 0;
  bool in_velocity = false;
  double value = 0.0;  ///< 0: the step is called bad, though it is good

  int seen = 0;
  std::string found;  ///< by the check that followed
};
Fault fault;

}  // namespace

std::string find_trouble_after_fault(const Model& model, double h, const State& state) {
  if (fault.seen++ != fault.at) return true_find_trouble(model, h, state);
  if (fault.value == 0.0) return "as if it were bad";
  auto& muscle = const_cast<State&>(state).muscles[fault.muscle];
  (fault.in_velocity ? muscle.v : muscle.x)[fault.node][fault.component] = fault.value;
  return fault.found = true_find_trouble(model, h, state);
}

namespace {

class Faults : public testing::Test {
 protected:
  Faults() {
    model_ = build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
                                    {"solver.substeps=4", "skin.enabled=false"}));
    state_ = initial_state(model_);
    settle(model_, parallel_, state_);
  }
  // Two frames on from the present state.
  std::vector<double> two_frames(const Fault& with) {
    fault = with;
    State state = state_;
    for (int frame = 1; frame <= 2; ++frame) {
      step_frame(model_, state_.time + frame / model_.scene.fps, parallel_, state, seconds_);
    }
    return pack_state(state);
  }
  void go_on() {
    fault = {};
    step_frame(model_, state_.time + 1.0 / model_.scene.fps, parallel_, state_, seconds_);
  }

  Model model_;
  State state_;
  Parallel parallel_{1};
  StageSeconds seconds_;
};

TEST_F(Faults, FiveHundredAreNamedAndTakenBackWhole) {
  std::mt19937 random(1);
  constexpr double kValues[] = {std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity(), 1e30, -1e30};
  std::vector<double> expected[8];  // by the substep that was taken back
  for (int i = 0; i < 500; ++i) {
    if (i % 50 == 0) {
      go_on();
      for (int at = 0; at < 8; ++at) {
        Fault called_bad;
        called_bad.at = at;
        expected[at] = two_frames(called_bad);
      }
      EXPECT_NE(expected[0], two_frames({}));  // halved: other bytes
    }
    Fault one;
    one.at = static_cast<int>(random() % 8);
    one.muscle = static_cast<int>(random() % 2);
    one.node = static_cast<int>(random() % state_.muscles[one.muscle].x.size());
    one.component = static_cast<int>(random() % 3);
    one.in_velocity = random() % 4 == 0;
    one.value = kValues[random() % 4];
    EXPECT_EQ(two_frames(one), expected[one.at]) << i;
    EXPECT_NE(fault.found.find("muscle \"" + model_.muscles[one.muscle].name + "\", node " +
                               std::to_string(one.node) + " at"),
              std::string::npos)
        << i << ": " << fault.found;
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace thew
