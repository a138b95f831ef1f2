// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/parting.h"

#include <gtest/gtest.h>

#include "sim/cache/cache.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/contacts.h"
#include "sim/solver/state_archive.h"

namespace thew::tests {
namespace {

int muscle_of(const Model& model, const std::string& name) {
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    if (model.muscles[m].name == name) return static_cast<int>(m);
  }
  ADD_FAILURE() << name;
  return 0;
}

void shift(const Model& model, int m, const Vec3& by, State& state) {
  for (size_t i = 0; i < state.muscles[m].x.size(); ++i) {
    if (model.muscles[m].free_nodes[i]) state.muscles[m].x[i] += to_point(by);
  }
}

Vec3 middle_of(const State& state, int m) {
  Vec3 sum = Vec3::Zero();
  for (const Point& p : state.muscles[m].x) sum += to_vec(p);
  return sum / static_cast<double>(state.muscles[m].x.size());
}

size_t crossings(const Model& model, int a, int b, State& state) {
  for (const int m : {a, b}) {
    refit_bvh(model.surfaces[m].surface, state.muscles[m].x, state.muscles[m].bvh);
  }
  const MuscleState &one = state.muscles[a], &other = state.muscles[b];
  return crossing_triangles(model.surfaces[a].surface, one.bvh, one.x, model.surfaces[b].surface,
                            other.bvh, other.x)
      .size();
}

// On the straight arm the biceps' heads are pressed into one another, and the anconeus deep into
// the elbow, out of which no step of a millimetre leads.
TEST(PartMuscles, OneThatIsStuckKeepsNoOthersCrossed) {
  const Model model =
      build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {"skin.enabled=false"}));
  Parallel parallel(1);
  State state = initial_state(model);
  settle(model, parallel, state);
  const int a = muscle_of(model, "biceps_long"), b = muscle_of(model, "biceps_short");
  const int stuck = muscle_of(model, "anconeus");
  ASSERT_EQ(crossings(model, a, b, state), 0u);
  const Vec3 towards = (middle_of(state, a) - middle_of(state, b)).normalized();
  for (int i = 0; i < 20 && crossings(model, a, b, state) == 0; ++i) {
    shift(model, b, 3e-4 * towards, state);  // m
  }
  shift(model, stuck, Vec3(0.015, 0.0, -0.01), state);
  ASSERT_GT(crossings(model, a, b, state), 0u);
  update_colliders(model, state);
  find_all_contacts(model, parallel, state);
  const Points before = state.muscles[stuck].x;
  EXPECT_TRUE(part_muscles(model, parallel, state));
  EXPECT_EQ(crossings(model, a, b, state), 0u);
  EXPECT_EQ(largest_distance(state.muscles[stuck].x, before), 0.0);
}

// What crosses by the rounding of files alone, some 1e-8 m, has to be parted too.
TEST(PartMuscles, SeesThePositionsThatAFileHolds) {
  const Model model =
      build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {"skin.enabled=false"}));
  Parallel parallel(1);
  State state = initial_state(model);
  update_colliders(model, state);
  find_all_contacts(model, parallel, state);
  part_muscles(model, parallel, state);
  ASSERT_EQ(state.parting.written.size(), state.colliders.size());
  bool any_rounded = false;
  for (size_t c = 0; c < state.colliders.size(); ++c) {
    const Points &x = *state.colliders[c].x, &written = state.parting.written[c];
    ASSERT_EQ(written.size(), x.size());
    for (size_t i = 0; i < x.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(written[i][k], as_float(x[i][k]));
        any_rounded = any_rounded || written[i][k] != x[i][k];
      }
    }
  }
  EXPECT_TRUE(any_rounded);
}

}  // namespace
}  // namespace thew::tests
