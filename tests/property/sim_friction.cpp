// SPDX-License-Identifier: Apache-2.0
//
// Coulomb's law, by the block on a slope of atan(0.3), whose motion is known in closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

constexpr double kAlong = 2.81887, kOnto = 9.39623;  // m/s^2, the scene's gravity

struct Slide {
  Model model;
  State state;
  Parallel parallel{1};

  explicit Slide(const std::vector<std::string>& overrides)
      : model(build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/slope/scene.toml", overrides))),
        state(initial_state(model)) {}
  void go_to(int frame) {
    StageSeconds seconds;
    for (int f = 1 + static_cast<int>(std::lround(state.time * model.fps)); f < frame; ++f) {
      step_frame(model, f / model.fps, parallel, state, seconds);
    }
  }
  // Position (m) and speed (m/s) of the whole block along the slope.
  double mean(const Points& rows) const {
    double sum = 0.0, mass = 0.0;
    for (size_t i = 0; i < rows.size(); ++i) {
      sum += model.muscles[0].mass[i] * rows[i][0];
      mass += model.muscles[0].mass[i];
    }
    return sum / mass;
  }
  double place() const { return mean(state.muscles[0].x); }
  double speed() const { return mean(state.muscles[0].v); }
};

// After the block has fallen the 0.1 mm by which it starts above the slope.
double acceleration(const std::vector<std::string>& overrides) {
  Slide slide(overrides);
  slide.go_to(9);
  const double before = slide.speed();
  slide.go_to(17);
  return (slide.speed() - before) * slide.model.fps / 8.0;
}

TEST(Friction, WithoutItTheBlockFallsAlongTheSlopeFreely) {
  for (const auto& [iterations, error] : {std::pair{"2", 1e-2}, {"40", 5e-4}}) {
    EXPECT_NEAR(acceleration({std::string("solver.iterations=") + iterations}), kAlong,
                error * kAlong)
        << iterations;
  }
}

TEST(Friction, ASlidingBlockIsBrakedByItsShareOfTheWeight) {
  for (const double friction : {0.05, 0.2, 0.28}) {
    const double expected = kAlong - friction * kOnto;
    EXPECT_NEAR(acceleration({"contact.friction=" + std::to_string(friction)}), expected,
                2e-3 * kAlong)
        << friction;
  }
}

TEST(Friction, AboveTheSlopesTangentItStays) {
  for (const char* friction : {"0.31", "0.5", "2"}) {
    Slide slide({std::string("contact.friction=") + friction});
    slide.go_to(9);
    const double place = slide.place();
    EXPECT_LT(std::abs(place), 5e-4) << friction;  // it slid while it landed
    slide.go_to(17);
    EXPECT_LT(std::abs(slide.place() - place), 5e-5) << friction;
    EXPECT_LT(std::abs(slide.speed()), 5e-4) << friction;
  }
}

TEST(Friction, ABeltTakesTheBlockAlong) {
  Slide slide({"contact.friction=0.2", "scene.gravity=[0,-9.81,0]",
               "rig.clip={interpolation=\"linear\",keys={belt=[[1,-0.3],[25,0.7]]}}"});  // 1 m/s
  slide.go_to(5);
  const double before = slide.speed();
  slide.go_to(9);
  EXPECT_NEAR((slide.speed() - before) * 6.0, 0.2 * 9.81, 0.02);
  slide.go_to(17);  // 0.51 s are enough
  EXPECT_NEAR(slide.speed(), 1.0, 1e-3);
}

TEST(Friction, GoesOnFromAKeptStateToTheBit) {
  Slide whole({"contact.friction=0.2"});
  whole.go_to(6);
  Slide resumed({"contact.friction=0.2"});
  unpack_state(whole.model, pack_state(whole.state), resumed.state);
  for (Slide* slide : {&whole, &resumed}) slide->go_to(9);
  EXPECT_EQ(pack_state(resumed.state), pack_state(whole.state));
}

}  // namespace
}  // namespace thew::tests
