// SPDX-License-Identifier: Apache-2.0
//
// A real muscle, in millimetres and of another person, flexes on bones beside it.
#include <gtest/gtest.h>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class RealBiceps : public TempFolder {};

TEST_F(RealBiceps, FlexesWithoutLosingVolume) {
  const fs::path data = THEW_SHARED_DATA;
  const fs::path scene = fs::path(THEW_SOURCE_DIR) / "tests" / "scenes" / "biceps_stl";
  for (const char* name : {"biceps.stl", "humerus.stl", "ulna.stl"}) {
    if (!fs::exists(data / name)) GTEST_SKIP() << data / name << " is not there";
    fs::copy_file(data / name, folder / name);
  }
  for (const char* name : {"scene.toml", "rig.urdf"}) fs::copy_file(scene / name, folder / name);
  const Model model = build_model(read_scene(folder / "scene.toml"));
  ASSERT_EQ(model.muscles.size(), 1u);
  EXPECT_EQ(model.muscles[0].rest.triangles.size(), 3840u);
  EXPECT_NEAR(model.muscles[0].rest_volume, 320e-6, 1e-6);  // mm^3 became m^3
  Parallel parallel(1);
  State state = initial_state(model);
  settle(model, parallel, state);
  const double long_path = state.muscles[0].pose.path_length;
  StageSeconds seconds;
  double worst = 0.0;
  for (int frame = 2; frame <= 24; ++frame) {
    step_frame(model, (frame - 1) / model.fps, parallel, state, seconds);
    worst = std::max({worst, state.muscles[0].volume_error, state.muscles[0].substep_volume_error});
  }
  EXPECT_LE(worst, 1e-12);
  EXPECT_LT(state.muscles[0].pose.path_length, 0.8 * long_path);
}

}  // namespace
}  // namespace thew::tests
