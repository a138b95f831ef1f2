// SPDX-License-Identifier: Apache-2.0
//
// What a file rounds off decides nothing: the same character by another program, a hair larger,
// moves alike in every frame of a fold.
#include <gtest/gtest.h>

#include <cstdio>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

using namespace sim;

const std::filesystem::path kPainted =
    std::filesystem::path(THEW_SOURCE_DIR) / "tests/scenes/figure/painted.toml";

std::vector<Points> skins_of(const std::vector<std::string>& overrides) {
  const Model model = build_model(read_scene(kPainted, overrides));
  Parallel parallel(1);
  State state = initial_state(model);
  StageSeconds seconds;
  settle(model, parallel, state);
  std::vector<Points> out = {state.skin.x};
  for (int frame = model.first_frame + 1; frame <= model.last_frame; ++frame) {
    step_frame(model, (frame - model.first_frame) / model.fps, parallel, state, seconds);
    out.push_back(state.skin.x);
  }
  return out;
}

// A wall of a fold that was found or not by the last digit moved the skin by 2.7 mm in frame 9 and
// by 6 mm in frame 16.
TEST(RoundingErrors, DoNotGrowInTheFoldOfACharacter) {
  constexpr double kLarger = 1e-7;  // of all lengths: 0.2 um, what float32 leaves of 2 m
  const std::vector<Points> skins = skins_of({}), others = skins_of({"rig.scale=1.0000001"});
  ASSERT_EQ(skins.size(), 16u);
  for (size_t k = 0; k < skins.size(); ++k) {
    const double apart = largest_distance(skins[k], others[k]);
    std::printf("frame %zu: %.2g m\n", k + 1, apart);
    EXPECT_GT(apart, 0.1 * kLarger);  // it is another character
    EXPECT_LT(apart, 100.0 * kLarger) << "frame " << k + 1;
  }
}

// The skin begins where it stays: a step more in which nothing moves leaves it there.
TEST(RoundingErrors, AreNotOfAStartOnTheWayToRest) {
  const Model model =
      build_model(read_scene(kPainted, {"rig.clip.keys.elbow=[[1, 75], [16, 75]]"}));
  Parallel parallel(1);
  State state = initial_state(model);
  StageSeconds seconds;
  settle(model, parallel, state);
  const Points start = state.layer.x;
  for (int k = 0; k < 10; ++k) rest_skin(model, skin::kReturnAtRest, parallel, state, seconds);
  const double moved = largest_distance(start, state.layer.x);
  std::printf("%.2g m\n", moved);
  EXPECT_LT(moved, 5e-5);
}

}  // namespace
}  // namespace thew::tests
