// SPDX-License-Identifier: Apache-2.0
//
// A state that is written and read back takes the next step to the same bytes, in every frame and
// also with its loops run backwards. A resumed bake depends on this. The scenes have a fold,
// contact, friction, a skin, a character, and each integrator.
#include <cmath>

#include "sim/fidelity/planner.h"
#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "tests/property/every.h"
#include "tests/unit/sim/order.h"
#include "tests/unit/tools/fit/new.h"

namespace thew::tests {
namespace {

void expect_same(const Points& a, const Points& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(to_vec(a[i]), to_vec(b[i])) << what << ", node " << i;
  }
}

void expect_same(const Model& model, const State& a, const State& b, const std::string& when) {
  for (size_t m = 0; m < a.muscles.size(); ++m) {
    expect_same(a.muscles[m].x, b.muscles[m].x, when + ", " + model.muscles[m].name);
  }
  for (size_t k = 0; k < a.bones.size(); ++k) {
    expect_same(a.bones[k].x, b.bones[k].x, when + ", " + model.bones[k].name);
  }
  expect_same(a.skin.x, b.skin.x, when + ", the skin");
  EXPECT_TRUE(pack_state(a) == pack_state(b)) << when << ": something else that a part holds";
}

// Goes on to the last frame. After each the next frame is stepped twice, from the state itself and
// from the packed state of a part.
void go_on(const Model& model, int last, Parallel& parallel, State& whole) {
  StageSeconds seconds;
  const int now = model.first_frame + static_cast<int>(std::lround(whole.time * model.fps));
  for (int f = now + 1; f <= last && !testing::Test::HasFailure(); ++f) {
    const double time = (f - model.first_frame) / model.fps;
    State resumed;
    unpack_state(model, pack_state(whole), resumed);
    step_frame(model, time, parallel, whole, seconds);
    loops_run_backwards = true;
    step_frame(model, time, parallel, resumed, seconds);
    loops_run_backwards = false;
    expect_same(model, whole, resumed, "frame " + std::to_string(f));
  }
}

// Settled, from the first frame.
void run(const Model& model, int last = 0) {
  Parallel parallel(2);
  State whole = initial_state(model);
  settle(model, parallel, whole);
  go_on(model, last == 0 ? model.last_frame : last, parallel, whole);
}

Model scene_of(const std::string& name, const std::vector<std::string>& overrides = {}) {
  return build_model(read_scene(fs::path(THEW_SOURCE_DIR) / name, overrides));
}

TEST(ResumedStep, OfTheArmAndItsSkinThroughTheFold) { run(scene_of("assets/arm/arm.toml")); }

// Its first frames, and those into the fold, whose pose is solved by itself; or all of them.
TEST(ResumedStep, OfTheArmWithoutInertia) {
  const Model model = scene_of("assets/arm/arm.toml", {"solver.integrator=quasi_static"});
  if (every(2) == 1) return run(model, 61);
  run(model, 3);
  Parallel parallel(2);
  StageSeconds seconds;
  State bent;
  solve_lone_frame(model, (56 - model.first_frame) / model.fps, parallel, bent, seconds);
  bent.way.reset();  // from now on in the clip
  go_on(model, 61, parallel, bent);
}

TEST(ResumedStep, OfTwoMusclesThatPressUnderEachIntegrator) {
  for (const char* integrator : {"local_global", "quasi_static", "xpbd", "explicit"}) {
    SCOPED_TRACE(integrator);
    run(scene_of("tests/scenes/pair/scene.toml", {std::string("solver.integrator=") + integrator}),
        10);
  }
}

TEST(ResumedStep, UnderEachWayToHoldTheVolume) {
  for (const char* volume : {"none", "penalty", "printed", "linear", "zonal"}) {
    SCOPED_TRACE(volume);
    run(scene_of("tests/scenes/one_muscle/scene.toml", {std::string("solver.volume=") + volume}));
  }
}

TEST(ResumedStep, OfABodyThatSlidesAndOneThatMeetsItself) {
  run(scene_of("tests/scenes/slope/scene.toml"), 18);
  run(scene_of("tests/scenes/horseshoe/scene.toml"), 40);
}

TEST(ResumedStep, UnderABallFromACache) {
  for (const char* integrator : {"local_global", "quasi_static"}) {
    run(scene_of("tests/scenes/pair/ball.toml", {std::string("solver.integrator=") + integrator}));
  }
}

TEST(ResumedStep, UnderATolerance) {
  Model model =
      scene_of("tests/scenes/pair/scene.toml", {"solver={ tolerance = { position = \"1 mm\" } }"});
  model.fidelity = plan_fidelity(model, 2).fidelity;
  run(model);
}

class ResumedFigure : public NewScene {};

TEST_F(ResumedFigure, OfACharacterAndItsSkin) {
  ASSERT_EQ(new_command(asked(kFigure, "both")), ExitCode::kDone);
  run(build_model(read_scene(folder / "character.toml", {})));
}

}  // namespace
}  // namespace thew::tests
