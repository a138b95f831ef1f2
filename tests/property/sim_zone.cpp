// SPDX-License-Identifier: Apache-2.0
//
// The automatic deformation zone (paper eq. 15, mended) under a bar that presses on a muscle.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

struct Pressed {
  Model model;
  State state;
  std::vector<double> radius;  // of the zone, by frame
  double worst_volume = 0.0;
};

Pressed press(const std::vector<std::string>& overrides) {
  Pressed out;
  out.model =
      build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pressed/scene.toml", overrides));
  Parallel parallel(1);
  out.state = initial_state(out.model);
  settle(out.model, parallel, out.state);
  StageSeconds seconds;
  for (int f = 1; f < 48; ++f) {
    step_frame(out.model, f / out.model.fps, parallel, out.state, seconds);
    out.radius.push_back(out.state.muscles[0].zone_radius);
    out.worst_volume = std::max(out.worst_volume, out.state.muscles[0].substep_volume_error);
  }
  return out;
}

// Largest relative swelling of sections more than 7 cm from the bar; the belly spans 24 cm.
double swelling_far_away(const Pressed& run) {
  const Muscle& muscle = run.model.muscles[0];
  const Points rest = to_points(muscle.rest.vertices);
  double most = 0.0;
  for (const double u : {0.1, 0.15, 0.2, 0.8, 0.85, 0.9}) {
    const CarriedPose& pose = run.state.muscles[0].pose;
    most = std::max(most, section_area_at(muscle, pose, run.state.muscles[0].x, u) /
                                  section_area_at(muscle, pose, rest, u) -
                              1.0);
  }
  return most;
}

TEST(Zone, GrowsWithTheLoadUpToItsLimit) {
  const Pressed run = press({});
  EXPECT_EQ(run.radius.front(), 0.0);  // no load yet
  const auto first =
      std::find_if(run.radius.begin(), run.radius.end(), [](double r) { return r > 0; });
  ASSERT_NE(first, run.radius.end());
  EXPECT_GE(*first, 0.03);
  for (auto r = first + 1; r != run.radius.end(); ++r) EXPECT_GE(*r, *(r - 1));
  EXPECT_GT(run.radius.back(), *first);
  EXPECT_LE(run.radius.back(), 0.12);
}

TEST(Zone, HoldsTheVolumeAndKeepsFarPartsStill) {
  const Pressed local = press({"muscle.muscle.weights.zone.per_impulse=0"});
  const Pressed global = press({"muscle.muscle.weights=even"});
  EXPECT_LE(local.worst_volume, 1e-12);
  EXPECT_LE(global.worst_volume, 1e-12);
  EXPECT_GT(swelling_far_away(global), 1e-3);
  EXPECT_LT(swelling_far_away(local), 0.5 * swelling_far_away(global));
}

TEST(Zone, NothingOfTheMuscleIsLeftInsideTheBar) {
  Pressed run = press({});
  Parallel parallel(1);
  refit_all(run.model, parallel, run.state);
  const Surface& bar = run.model.surfaces[run.model.muscles.size()].surface;
  for (const Point& x : run.state.muscles[0].x) {
    const ClosestPoint at =
        closest_point(bar, run.state.bones[0].bvh, run.state.bones[0].x, to_vec(x), 0.01);
    if (at.triangle >= 0) {
      EXPECT_GT(at.distance, -5e-4);
    }
  }
}

}  // namespace
}  // namespace thew::tests
