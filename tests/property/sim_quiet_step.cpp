// SPDX-License-Identifier: Apache-2.0
//
// A step allocates nothing: frames that have been stepped before, from the same state and with the
// memory allocated by then, call no operator new. So a step's scratch is kept from step to step and
// grows only where there is more of something than ever before, such as contacts.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"

namespace {

std::atomic<long> calls_of_new{0};

void* counted(std::size_t bytes, std::size_t alignment) noexcept {
  ++calls_of_new;
  void* memory = nullptr;
  return posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) == 0 ? memory : nullptr;
}

void* counted_or_thrown(std::size_t bytes, std::size_t alignment) {
  if (void* memory = counted(bytes, alignment)) return memory;
  throw std::bad_alloc();
}

constexpr std::size_t kUsual = alignof(std::max_align_t);

}  // namespace

void* operator new(std::size_t bytes) { return counted_or_thrown(bytes, kUsual); }
void* operator new[](std::size_t bytes) { return counted_or_thrown(bytes, kUsual); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted_or_thrown(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return counted_or_thrown(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return counted(bytes, kUsual);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return counted(bytes, kUsual);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace thew::tests {
namespace {

struct Frames {
  long allocations = 0;
  size_t contacts = 0, own = 0;  // in all of them, and of a muscle with itself
};

// Allocations in `count` frames after the first two, when they are stepped for the third time: by
// then both of two buffers that are swapped in each step have reached their largest size.
Frames stepped_again(const Model& model, int count) {
  constexpr int kLead = 2, kTimes = 3;
  Parallel parallel(2);
  StageSeconds seconds;
  State state = initial_state(model);
  const auto step = [&](int frame) {
    step_frame(model, frame / model.fps, parallel, state, seconds);
  };
  for (int frame = 1; frame <= kLead; ++frame) step(frame);
  const State begin = state;
  Frames frames;
  for (int time = 1; time <= kTimes; ++time) {
    state = begin;
    frames = {};
    for (int frame = kLead + 1; frame <= kLead + count; ++frame) {
      const long before = calls_of_new;
      step(frame);
      frames.allocations += calls_of_new - before;
      for (int m = 0; m < state.count(); ++m) {
        frames.contacts += state.muscles[m].contacts.size();
        for (const Contact& contact : state.muscles[m].contacts) frames.own += contact.other == m;
      }
    }
  }
  return frames;
}

// Allocations while settling, from the end of its first frame on, when it is done for the third
// time.
long settled_again(const Model& model) {
  constexpr int kTimes = 3;
  Parallel parallel(2);
  const State begin = initial_state(model);
  State state = begin;
  long first = 0, last = 0;
  for (int time = 1; time <= kTimes; ++time) {
    state = begin;
    first = 0;
    settle(model, parallel, state, [&] {
      last = calls_of_new;
      if (first == 0) first = last;
    });
  }
  return last - first;
}

Model model_of(const std::string& scene, const std::vector<std::string>& overrides) {
  return build_model(read_scene(THEW_SOURCE_DIR "/" + scene, overrides));
}

// Two muscles that press on each other, and two bones.
Model pair(std::vector<std::string> overrides, bool has_skin = false) {
  overrides.insert(overrides.end(), {"solver.substeps=2", "muscle.side.weights=even"});
  Model model = model_of("tests/scenes/pair/scene.toml", overrides);
  model.has_skin = has_skin;
  return model;
}

class EachIntegrator : public testing::TestWithParam<const char*> {};

TEST_P(EachIntegrator, AllocatesNothing) {
  const Frames frames = stepped_again(pair({std::string("solver.integrator=") + GetParam()}), 7);
  EXPECT_GT(frames.contacts, 20u);
  EXPECT_EQ(frames.allocations, 0);
}

INSTANTIATE_TEST_SUITE_P(QuietStep, EachIntegrator,
                         testing::Values("explicit", "xpbd", "local_global", "quasi_static"),
                         [](const auto& info) { return std::string(info.param); });

class QuietStep : public TempFolder {};

TEST_F(QuietStep, MusclesThatRub) {
  const Frames frames = stepped_again(pair({"contact.friction=0.4"}), 7);
  EXPECT_GT(frames.contacts, 20u);
  EXPECT_EQ(frames.allocations, 0);
}

TEST_F(QuietStep, AMuscleThatTouchesItself) {
  const Frames frames =
      stepped_again(model_of("tests/scenes/horseshoe/scene.toml", {"contact.friction=0.4"}), 25);
  EXPECT_GT(frames.own, 50u);
  EXPECT_EQ(frames.allocations, 0);
}

TEST_F(QuietStep, VolumeZones) {
  EXPECT_EQ(stepped_again(pair({"muscle.front.zones=4"}), 7).allocations, 0);
}

TEST_F(QuietStep, WeightsThatFollowTheLoad) {
  const Model model =
      pair({"muscle.front.weights={ zone = { smallest_radius = 0.005, per_impulse = 0.01 } }"});
  ASSERT_TRUE(model.muscles[0].settings.zone || model.muscles[1].settings.zone);
  const Frames frames = stepped_again(model, 7);
  EXPECT_GT(frames.contacts, 20u);
  EXPECT_EQ(frames.allocations, 0);
}

TEST_F(QuietStep, ALayeredSkin) {
  EXPECT_EQ(stepped_again(pair({}, true), 7).allocations, 0);
  EXPECT_EQ(stepped_again(pair({"skin.volume=exact"}, true), 7).allocations, 0) << "its volume";
}

TEST_F(QuietStep, WhatIsPaintedAndPullsByItsJoint) {
  const Model model = model_of("tests/scenes/pair/painted.toml", {});
  ASSERT_FALSE(model.skin.stick.empty());
  EXPECT_EQ(stepped_again(model, 7).allocations, 0);
}

TEST_F(QuietStep, ABallFromACache) {
  const Model model =
      model_of("tests/scenes/pair/ball.toml", {"solver.substeps=2", "muscle.side.weights=even",
                                               "collider.ball.start=-5"});  // near from the start
  EXPECT_EQ(stepped_again(model, 7).allocations, 0);
}

// Under a tolerance: a muscle without forces beside one that has them.
TEST_F(QuietStep, ATolerance) {
  Model model = pair({});
  const std::vector<Vec3> none(model.muscles[0].rest.vertices.size(), Vec3::Zero());
  model.fidelity =
      Fidelity{.substeps = 2, .muscles = {{Level::kGeometric, 1, {{0.0}, {none}}}, {}}};
  EXPECT_EQ(stepped_again(model, 7).allocations, 0);
}

TEST_F(QuietStep, AllMusclesOfTheArm) {
  Model model = model_of("assets/arm/arm.toml", {});
  const Frames frames = stepped_again(model, 5);
  EXPECT_GT(frames.contacts, 1000u);
  EXPECT_EQ(frames.allocations, 0);
}

// A character's animation moves all bodies, or keys move its hinges.
TEST_F(QuietStep, ACharacter) {
  std::filesystem::copy_file(THEW_SOURCE_DIR "/tests/scenes/figure/figure.gltf",
                             folder / "figure.gltf");
  const std::string begin =
      "[rig]\nfile = \"figure.gltf\"\n[[rig.hinge]]\nname = \"elbow\"\nbody = \"RightForeArm\"\n"
      "axis = [1, 0, 0]\nat_bind = 10\n[rig.clip]\n";
  const std::string end =
      "[[muscle]]\nname = \"a\"\npath = [[\"RightArm\", 0, 0, 0.02], [\"RightForeArm\", 0.1, 0, "
      "0.02]]\nprofile = { around = 8, rings = 6, radius = [[0, 0.01]] }\n";
  for (const char* clip :
       {"animation = \"wave\"\n", "unit = \"deg\"\nkeys = { elbow = [[1, 10], [12, 40]] }\n"}) {
    const Model model = build_model(read_scene(write("scene.toml", begin + clip + end)));
    EXPECT_EQ(stepped_again(model, 5).allocations, 0) << clip;
    const Model with_skin = build_model(
        read_scene(write("scene.toml", begin + clip + end + "[skin]\nkind = \"skinned\"\n")));
    EXPECT_EQ(stepped_again(with_skin, 5).allocations, 0) << clip << "with its skin";
    EXPECT_EQ(settled_again(model), 0) << clip << "while it settles";
  }
}

}  // namespace
}  // namespace thew::tests
