// SPDX-License-Identifier: Apache-2.0
//
// Scenes whose bones, props and skins move by caches: what is read, what is refused, and that a
// prop meets muscles as a bone does.
#include <gtest/gtest.h>

#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/cache/cached_mesh.h"
#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "skin/depth.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

const fs::path kPair = fs::path(THEW_SOURCE_DIR) / "tests/scenes/pair";

Model ball(const Settings& overrides = {}) {
  return build_model(read_scene(kPair / "ball.toml", overrides));
}

void run_to(const Model& model, int frame, State& state) {
  Parallel parallel(1);
  StageSeconds seconds;
  settle(model, parallel, state);
  for (int f = model.first_frame + 1; f <= frame; ++f) {
    step_frame(model, (f - model.first_frame) / model.fps, parallel, state, seconds);
  }
}

// By ray counts and exact distances, which share nothing with contact.
double deepest_in_ball(const Model& model, const State& state, const Points& x) {
  const BoneState& now = state.bones.back();
  const Surface& surface = model.surfaces.back().surface;
  return deepest_inside(surface, build_bvh(surface, now.x), now.x, x);
}

// The same of the nodes of the first muscle that no bone holds.
double depth_of_flesh(const Model& model, const State& state, const State& ball) {
  Points free;
  for (size_t i = 0; i < state.muscles[0].x.size(); ++i) {
    if (model.muscles[0].free_nodes[i]) free.push_back(state.muscles[0].x[i]);
  }
  return deepest_in_ball(model, ball, free);
}

class Press : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, Press, testing::Values("local_global", "quasi_static", "xpbd"));

TEST_P(Press, ABallThatFlattensStaysOutOfFleshAndSkin) {
  const Model model = ball({std::string("solver.integrator=") + GetParam()});
  ASSERT_TRUE(model.bones.back().prop && model.bones.back().bends());
  State state = initial_state(model);
  const Points before = state.muscles[0].x;
  run_to(model, 16, state);
  EXPECT_EQ(depth_of_flesh(model, state, state), 0.0);
  EXPECT_EQ(deepest_in_ball(model, state, state.skin.x), 0.0);
  EXPECT_LT(state.muscles[0].volume_error, 1e-12);
  const Model without = build_model(read_scene(kPair / "scene.toml", {}));
  State free = initial_state(without);
  run_to(without, 16, free);
  EXPECT_GT(largest_distance(free.muscles[0].x, state.muscles[0].x), 0.005);
  EXPECT_GT(depth_of_flesh(model, free, state), 0.005);  // or nothing was tried
}

TEST(Cached, APropIsWhereItsSamplesAre) {
  const Model model = ball();
  const CachedMesh cache = read_cached_mesh(kPair / "ball.obj", kPair / "ball.pc2", model.fps, 1.0);
  State state = initial_state(model);
  for (const auto& [time, sample] : {std::pair{0.0, 0}, {0.25, 1}, {0.5, 2}, {0.9, 2}}) {
    drive_bones(model, time, state);
    const Points& x = state.bones.back().x;
    ASSERT_EQ(x.size(), cache.rest.vertices.size());
    for (size_t i = 0; i < x.size(); ++i) {
      EXPECT_LT((to_vec(x[i]) - cache.samples.positions[sample][i]).norm(), 1e-15) << time;
    }
  }
}

// A surface that bends out by more than contact sees in a step: the step is divided.
TEST(Cached, WhatBendsTooFastIsTakenInParts) {
  Model model = ball();
  auto motion = std::make_shared<MeshMotion>(*model.bones.back().motion);
  motion->poses[1] = motion->poses[2];
  for (Point& p : motion->shapes[1]) p *= 0.5;
  for (Point& p : motion->shapes[2]) p *= 1.3;
  motion->times = {0.0, 0.25, 0.25 + 1.0 / 24.0};
  model.bones.back().motion = motion;
  State state = initial_state(model);
  run_to(model, 8, state);
  EXPECT_LT(depth_of_flesh(model, state, state), 1e-4);
  EXPECT_LT(state.muscles[0].volume_error, 1e-12);
  Parallel parallel(1);
  StageSeconds seconds;
  step_frame(model, 8.0 / model.fps, parallel, state, seconds);
  EXPECT_EQ(depth_of_flesh(model, state, state), 0.0);
}

TEST(Cached, AFrameOfQuasiStaticStandsByItself) {
  const Model model = ball({"solver.integrator=quasi_static"});
  Parallel one(1), two(2);
  StageSeconds seconds;
  State a = initial_state(model), b = initial_state(model);
  solve_lone_frame(model, 0.25, one, a, seconds);
  solve_lone_frame(model, 0.5, one, a, seconds);
  solve_lone_frame(model, 0.5, two, b, seconds);
  EXPECT_TRUE(pack_state(a) == pack_state(b));
  EXPECT_EQ(depth_of_flesh(model, a, a), 0.0);
}

// What a bake resumes from: ball, muscles and skin go on to the same bytes.
TEST(Cached, AStateThatIsReadBackTakesTheSameStep) {
  const Model model = ball();
  Parallel parallel(1);
  StageSeconds seconds;
  State whole = initial_state(model);
  settle(model, parallel, whole);
  for (int f = 1; f < 14; ++f) {
    State resumed;
    unpack_state(model, pack_state(whole), resumed);
    step_frame(model, f / model.fps, parallel, whole, seconds);
    step_frame(model, f / model.fps, parallel, resumed, seconds);
    EXPECT_TRUE(pack_state(whole) == pack_state(resumed)) << f;
    EXPECT_TRUE(same_bytes(whole.bones.back().x, resumed.bones.back().x)) << f;
  }
}

class CachedScene : public TempFolder {
 protected:
  CachedScene() {
    fs::copy(kPair, folder, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
  void edit(const std::string& from, const std::string& to) {
    const fs::path file = folder / "ball.toml";
    std::ifstream in(file);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write("ball.toml", text.replace(at, from.size(), to));
  }
  std::string error() {
    try {
      build_model(read_scene(folder / "ball.toml"));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(CachedScene, RefusesWithPlaceAndNextMove) {
  edit("cache = \"ball.pc2\"", "cache = \"ball.obj\"");
  EXPECT_HAS(error(), "ball.obj: animated meshes are read from .h5 of Thew, .pc2 and .mdd; export");
  edit("cache = \"ball.obj\"", "cache = \"ball.pc2\"");
  edit("mesh = \"ball.obj\"", "mesh = \"skin.obj\"");
  EXPECT_HAS(error(), "ball.pc2: has 162 points, and its mesh 322 vertices; export it again");
  edit("mesh = \"skin.obj\"\ncache", "mesh = \"ball.obj\"\ncache");
  edit("name = \"ball\"\nmesh", "name = \"ulna\"\nmesh");
  EXPECT_HAS(error(), "a body is called \"ulna\" already; give another name");
  edit("name = \"ulna\"\nmesh = \"ball.obj\"", "name = \"front\"\nmesh = \"ball.obj\"");
  EXPECT_HAS(error(), "a second [collider.front]; give each a name of its own");
}

TEST_F(CachedScene, AScaleAndAStartMoveIt) {
  const Model plain = build_model(read_scene(folder / "ball.toml"));
  edit("cache = \"ball.pc2\"", "cache = \"ball.pc2\"\nscale = 0.5\nstart = 4");
  const Model model = build_model(read_scene(folder / "ball.toml"));
  EXPECT_NE(model.hash, plain.hash);
  const MeshMotion &motion = *model.bones.back().motion, &whole = *plain.bones.back().motion;
  EXPECT_NEAR(motion.times[0], 3.0 / 24.0, 1e-15);
  EXPECT_LT((motion.poses[1].translation() - 0.5 * whole.poses[1].translation()).norm(), 1e-12);
}

TEST_F(CachedScene, AStillPropHasNoCache) {
  edit("cache = \"ball.pc2\"\n", "");
  const Model model = build_model(read_scene(folder / "ball.toml"));
  EXPECT_TRUE(model.bones.back().prop && !model.bones.back().motion);
  State state = initial_state(model);
  EXPECT_TRUE(same_bytes(state.bones.back().x, to_points(model.bones.back().in_body.vertices)));
}

// Two bars, of which one turns about the other's end and bends.
TEST_F(CachedScene, ABoneThatBendsIsSaid) {
  std::string bytes("POINTCACHE2\0", 12);
  const auto put = [&](auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const TriMesh bone = read_cached_mesh(kPair / "ball.obj", kPair / "ball.pc2", 24.0, 1.0).rest;
  put(std::int32_t{1});
  put(static_cast<std::int32_t>(bone.vertices.size()));
  for (const float value : {1.0f, 1.0f}) put(value);
  put(std::int32_t{2});
  for (const double stretch : {1.0, 1.1}) {
    for (const Vec3& p : bone.vertices) {
      for (int k = 0; k < 3; ++k) put(static_cast<float>(k == 0 ? stretch * p[k] : p[k]));
    }
  }
  write("bent.pc2", bytes);
  write("bent.toml",
        "[scene]\nframes = \"1-2\"\n[rig]\n[[rig.bone]]\nname = \"a\"\nmesh = \"ball.obj\"\n"
        "cache = \"bent.pc2\"\n[[muscle]]\nname = \"m\"\npath = [[\"a\", 0, 0.1, 0], [\"a\", 0, "
        "0.3, 0]]\n"
        "profile = { radius = [[0, 0.005], [1, 0.005]] }\n");
  const Model model = build_model(read_scene(folder / "bent.toml"));
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_HAS(model.warnings[0], "bone \"a\" bends by up to ");
  EXPECT_HAS(model.warnings[0],
             " mm, most in frame 2; muscles are fixed to its nearest rigid motion");
  EXPECT_TRUE(model.bones[0].bends());
}

}  // namespace
}  // namespace thew::tests
