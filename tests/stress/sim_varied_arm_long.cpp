// SPDX-License-Identifier: Apache-2.0
//
// No millimetre of a rest shape decides: the arm's bellies moved aside by up to a centimetre and
// made up to a fifth larger or smaller, so that they overlap at rest, flex without a crossing or a
// fold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/property/folds.h"

namespace thew::tests {
namespace {

// Each node of a belly moves by a direction across the belly's axis, most in the middle, and is
// swollen about that axis.
void vary(std::mt19937& random, MuscleDef& muscle) {
  std::uniform_real_distribution<double> evenly(-1.0, 1.0);
  std::vector<Vec3>& x = muscle.mesh.vertices;
  const Vec3 origin = x.front(), insertion = x.back();
  const Vec3 axis = (insertion - origin).normalized();
  Vec3 aside = Vec3(evenly(random), evenly(random), evenly(random));
  aside = (aside - aside.dot(axis) * axis).normalized();
  const double by = 0.01 * std::abs(evenly(random));
  const double thicker = std::sqrt(1.0 + 0.2 * evenly(random));  // a fifth of the volume
  const double length = (insertion - origin).norm();
  for (Vec3& p : x) {
    const double t = (p - origin).dot(axis) / length;
    const double middle = smoothstep(0.25, 0.5, t) * (1.0 - smoothstep(0.5, 0.75, t));
    const Vec3 on_axis = origin + t * length * axis;
    const double swollen = 1.0 + (thicker - 1.0) * middle;
    p = on_axis + swollen * (p - on_axis) + middle * by * aside;
  }
}

int crossings_of(const Model& model, const State& state) {
  int crossings = 0;
  for (int a = 0; a < state.count(); ++a) {
    const MuscleState& one = state.muscles[a];
    const Bvh tree = build_bvh(model.surfaces[a].surface, one.x);
    for (int b = a; b < state.count(); ++b) {
      const MuscleState& two = state.muscles[b];
      const Bvh other = build_bvh(model.surfaces[b].surface, two.x);
      crossings += static_cast<int>(crossing_triangles(model.surfaces[a].surface, tree, one.x,
                                                       model.surfaces[b].surface, other, two.x)
                                        .size());
    }
  }
  return crossings;
}

int folds_of(const Model& model, int m, const Points& x) {
  return folds_beyond_90(model.surfaces[m].surface, x);
}

class VariedArm : public testing::TestWithParam<int> {};

TEST_P(VariedArm, FlexesWithoutACrossingOrAFold) {
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  ModelDef def =
      define_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {"skin.enabled=false"}));
  for (MuscleDef& muscle : def.muscles) vary(random, muscle);
  const Model model = build_model(std::move(def));
  Parallel parallel(2);
  State state = initial_state(model);
  settle(model, parallel, state);
  StageSeconds unused;
  int frames = 0, folds = 0;
  for (int f = model.first_frame + 1; f <= model.last_frame; ++f) {
    step_frame(model, (f - model.first_frame) / model.fps, parallel, state, unused);
    frames += crossings_of(model, state) > 0;
    for (int m = 0; m < state.count(); ++m) {
      const int at_rest = folds_of(model, m, to_points(model.muscles[m].rest.vertices));
      folds += std::max(folds_of(model, m, state.muscles[m].x) - at_rest, 0);
    }
    for (const MuscleState& muscle : state.muscles) ASSERT_LE(muscle.volume_error, 1e-12);
  }
  EXPECT_EQ(frames, 0) << "frames with a crossing";
  EXPECT_EQ(folds, 0) << "in all frames";
}

INSTANTIATE_TEST_SUITE_P(Seeds, VariedArm, testing::Range(1, 21));

}  // namespace
}  // namespace thew::tests
