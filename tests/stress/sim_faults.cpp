// SPDX-License-Identifier: Apache-2.0
// Faults inside a substep and in the skin. The linker calls this file's functions in place of the
// health checks (CMakeLists.txt), so that the library needs no code for this test.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "sim/bake/bake.h"
#include "sim/cache/cache_parts.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/health.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/sim/order.h"

namespace thew::tests {
// By the linker's names: the checks themselves, and what is called in their place.
using Diagnosis = std::optional<StepDiagnosis>;
Diagnosis true_diagnose_step(const Model& model, double h, const State& state) __asm__(
    "__real__ZN4thew3sim13diagnose_stepERKNS0_5ModelEdRKNS0_5StateE");
Diagnosis diagnose_step_after_fault(const Model& model, double h, const State& state) __asm__(
    "__wrap__ZN4thew3sim13diagnose_stepERKNS0_5ModelEdRKNS0_5StateE");
Diagnosis true_diagnose_skin(const Model& model, const State& state) __asm__(
    "__real__ZN4thew3sim13diagnose_skinERKNS0_5ModelERKNS0_5StateE");
Diagnosis diagnose_skin_after_fault(const Model& model, const State& state) __asm__(
    "__wrap__ZN4thew3sim13diagnose_skinERKNS0_5ModelERKNS0_5StateE");

namespace {

/// The fault that is set before check number `at`, counted from 0, and before the `more` that
/// follow it.
struct Fault {
  int at = -1, more = 0;
  int muscle = 0, node = 0, component = 0;
  bool in_skin = false, in_velocity = false;
  double value = 0.0;  ///< 0: the step is called bad, though it is good

  bool until_held = false;  ///< bad whenever the muscle is solved, in check `at` and those after

  int seen = 0;
  Diagnosis found;  ///< by the check that followed
};
Fault fault;

bool is_due(bool in_skin) {
  if (fault.in_skin != in_skin) return false;
  const int now = fault.seen++;
  return fault.at >= 0 && now >= fault.at && now <= fault.at + fault.more;
}

}  // namespace

Diagnosis diagnose_step_after_fault(const Model& model, double h, const State& state) {
  if (!is_due(false)) return true_diagnose_step(model, h, state);
  if (fault.until_held) {
    const int m = fault.muscle;
    if (!has_forces(state.muscles[m].level)) return true_diagnose_step(model, h, state);
    StepDiagnosis diagnosis{"as if it were bad", -1, Cause::kEnergy};
    diagnosis.muscle = m;
    diagnosis.other = 0;
    return diagnosis;
  }
  if (fault.value == 0.0) return StepDiagnosis{"as if it were bad", -1, Cause::kEnergy};
  auto& muscle = const_cast<State&>(state).muscles[fault.muscle];
  (fault.in_velocity ? muscle.v : muscle.x)[fault.node][fault.component] = fault.value;
  return fault.found = true_diagnose_step(model, h, state);
}

Diagnosis diagnose_skin_after_fault(const Model& model, const State& state) {
  if (!is_due(true)) return true_diagnose_skin(model, state);
  SkinState& skin = const_cast<State&>(state).skin;
  Points* const rows[] = {&skin.x, &skin.offset, &skin.force, &skin.slip};
  (*rows[fault.muscle])[fault.node][fault.component] = fault.value;
  return fault.found = true_diagnose_skin(model, state);
}

namespace {

constexpr double kValues[] = {std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(), 1e30, -1e30};

class Faults : public testing::TestWithParam<const char*> {
 protected:
  static Model model_with(const std::vector<std::string>& more) {
    std::vector<std::string> set = {"solver.substeps=4"};
    set.insert(set.end(), more.begin(), more.end());
    return build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml", set));
  }
  void begin(const std::vector<std::string>& more) {
    model_ = model_with(more);
    state_ = initial_state(model_);
    settle(model_, parallel_, state_);
  }
  // Steps two frames from the present state. Returns the packed state and the measures.
  std::vector<double> two_frames(const Fault& with) {
    fault = with;
    State state = state_;
    for (int frame = 1; frame <= 2; ++frame) {
      step_frame(model_, state_.time + frame / model_.fps, parallel_, state, seconds_);
    }
    forget_searches(state);  // they begin anew after a fault, and find the same
    std::vector<double> all = pack_state(state);
    for (const MuscleState& muscle : state.muscles) {
      all.insert(all.end(),
                 {muscle.volume_error, muscle.substep_volume_error, 1.0 * muscle.unreached,
                  1.0 * muscle.weight_fallbacks, muscle.contact_impulse.impulse.norm(),
                  muscle.contact_impulse.angular_impulse.norm()});
    }
    return all;
  }
  void go_on() {
    fault = {};
    step_frame(model_, state_.time + 1.0 / model_.fps, parallel_, state_, seconds_);
  }

  Model model_;
  State state_;
  Parallel parallel_{1};
  StageSeconds seconds_;
};

// A fault is found in the same substep, named, and undone completely: the bytes are those of a run
// without it.
TEST_P(Faults, InNodesAreNamedAndLeaveNothing) {
  begin({"skin.enabled=false", std::string("solver.integrator=") + GetParam()});
  const bool is_explicit = std::string(GetParam()) == "explicit";
  const int checks = is_explicit ? 2 : 8, count = is_explicit ? 30 : 500;
  std::mt19937 random(1);
  std::vector<double> calm;
  for (int i = 0; i < count; ++i) {
    if (i % 50 == 0) {
      go_on();
      calm = two_frames({});
    }
    Fault one;
    one.at = static_cast<int>(random() % checks);
    one.muscle = static_cast<int>(random() % 2);
    one.node = static_cast<int>(random() % state_.muscles[one.muscle].x.size());
    one.component = static_cast<int>(random() % 3);
    one.in_velocity = random() % 4 == 0;
    one.value = kValues[random() % 4];
    EXPECT_EQ(two_frames(one), calm) << i;
    ASSERT_TRUE(fault.found) << i;
    EXPECT_EQ(fault.found->part, "muscle \"" + model_.muscles[one.muscle].name + "\"");
    EXPECT_EQ(fault.found->node, one.node) << i;
    if (HasFailure()) return;
  }
}
INSTANTIATE_TEST_SUITE_P(Of, Faults, testing::Values("local_global", "explicit"));

TEST_F(Faults, InTheSkinAreNamedAndLeaveNothing) {
  begin({"solver.substeps=1"});
  std::mt19937 random(2);
  std::vector<double> calm;
  for (int i = 0; i < 100; ++i) {
    if (i % 50 == 0) {
      go_on();
      calm = two_frames({});
    }
    Fault one;
    one.in_skin = true;
    one.at = static_cast<int>(random() % 2);
    one.muscle = static_cast<int>(random() % 4);  // which of its lists
    one.node = static_cast<int>(random() % state_.skin.x.size());
    one.component = static_cast<int>(random() % 3);
    one.value = kValues[random() % 4];
    EXPECT_EQ(two_frames(one), calm) << i;
    ASSERT_TRUE(fault.found) << i;
    EXPECT_EQ(fault.found->part, "skin");
    EXPECT_EQ(fault.found->node, one.node) << i;
    if (HasFailure()) return;
  }
}

TEST_F(Faults, ThatComeBackAreHalved) {
  begin({"skin.enabled=false"});
  Fault once, twice;
  once.at = twice.at = 2;
  twice.more = 3;  // the second try's first substep, too
  const std::vector<double> calm = two_frames({});
  EXPECT_EQ(two_frames(once), calm);
  EXPECT_NE(two_frames(twice), calm);
}

// The muscle is first stepped without contact with the other one, which does not help, and then is
// its carried shape at its exact volume until it can be solved again. It never jumps. In any frame
// a state that is written and read back goes on to the same bytes, also with its loops run
// backwards.
TEST_F(Faults, ThatStayPutTheirMuscleOnARung) {
  constexpr int kFrames = 24, kBad = 8, kGood = 14;
  const Model model = model_with({"skin.enabled=false", "solver.substeps=2"});
  State calm = initial_state(model);
  settle(model, parallel_, calm);
  State hurt = calm;
  std::vector<Rung> taken;
  double farthest = 0.0, fastest = 0.0, fastest_calm = 0.0;
  for (int frame = 1; frame <= kFrames; ++frame) {
    const double time = frame / model.fps;
    const auto step_bad = [&](State& state) {
      fault = {};
      fault.until_held = frame >= kBad && frame < kGood;
      fault.at = fault.until_held ? 0 : -1;
      fault.more = 1000;
      fault.muscle = 1;
      step_frame(model, time, parallel_, state, seconds_);
    };
    State again = initial_state(model);
    unpack_state(model, pack_state(hurt), again);
    const Points before = hurt.muscles[1].x, calm_before = calm.muscles[1].x;
    step_bad(hurt);
    loops_run_backwards = true;
    step_bad(again);
    loops_run_backwards = false;
    EXPECT_EQ(pack_state(hurt), pack_state(again)) << frame;
    fault = {};
    step_frame(model, time, parallel_, calm, seconds_);
    for (const MuscleState& muscle : hurt.muscles) EXPECT_LE(muscle.volume_error, 1e-12) << frame;
    taken.push_back(hurt.muscles[1].ladder.frame_rung);
    for (size_t i = 0; i < before.size(); ++i) {
      const Points &now = hurt.muscles[1].x, &then = calm.muscles[1].x;
      farthest = std::max(farthest, norm(now[i] - then[i]));
      fastest = std::max(fastest, norm(now[i] - before[i]));
      fastest_calm = std::max(fastest_calm, norm(then[i] - calm_before[i]));
    }
  }
  EXPECT_EQ(std::count(taken.begin(), taken.begin() + kBad - 1, Rung::kNone), kBad - 1);
  for (int frame = kBad; frame < kGood; ++frame) {
    EXPECT_EQ(taken[frame - 1], Rung::kCarried) << frame;
  }
  EXPECT_EQ(taken.back(), Rung::kNone);
  EXPECT_GT(farthest, 1e-4);  // it is another shape
  EXPECT_LT(fastest, fastest_calm + 0.5 * farthest);
  Model strict = model;
  strict.solver.rungs = false;
  fault = {};
  fault.at = 0;
  fault.more = 1000;
  fault.until_held = true;
  EXPECT_THROW(step_frame(strict, (kFrames + 1) / model.fps, parallel_, calm, seconds_),
               StepFailure);
  fault = {};
}

TEST_F(Faults, ThatStayEndTheBakeWithItsLastGoodFrame) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / ("thew_faults_" + std::to_string(getpid()));
  for (const bool in_skin : {false, true}) {
    std::filesystem::remove_all(folder);
    const Model model = model_with(
        {"solver.substeps=1", "scene.settle=0", "rig.clip.keys={ elbow = [[1, 0], [16, 20]] }"});
    fault = {};
    fault.at = 2;  // frame 4: the first is not stepped
    fault.more = 1000;
    fault.in_skin = in_skin;
    fault.muscle = in_skin ? 0 : 1;
    fault.node = 17;
    fault.value = kValues[0];
    std::string error;
    try {
      bake(model, {folder, {1, 2, 3, 4, 5, 6}, 1, false}, [](const BakeFrame&) { return true; });
    } catch (const StepFailure& failure) {
      error = failure.what();
      EXPECT_EQ(failure.code(), ErrorCode::kSolver);
      EXPECT_EQ(failure.frame, 4);
      EXPECT_EQ(failure.diagnosis.node, 17);
      EXPECT_EQ(failure.substeps, in_skin ? 0 : 16);
    }
    EXPECT_NE(error.find(in_skin ? "frame 4: skin, node 17: "
                                 : "frame 4 (substep 1 of 16): muscle \"side\", node 17: "),
              std::string::npos)
        << error;
    EXPECT_EQ(good_parts(folder / "bake.parts", bake_info(model, {1, 2, 3, 4, 5, 6})).size(), 3u);
    fault = {};
    const BakeResult rest =
        bake(model, {folder, {1, 2, 3, 4, 5, 6}, 1, true}, [](const BakeFrame&) { return true; });
    EXPECT_EQ(rest.resumed_frames, 3);
    EXPECT_EQ(rest.hash,
              bake(model, {folder / "calm", {1, 2, 3, 4, 5, 6}, 1, false}, [](const BakeFrame&) {
                return true;
              }).hash);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace thew::tests
