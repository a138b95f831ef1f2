// SPDX-License-Identifier: Apache-2.0
//
// Soft bodies without a path: the paper's own experiments as scenes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "muscles/volume.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

const std::string kPaper = THEW_SOURCE_DIR "/assets/paper/";

struct Outcome {
  Model model;
  State state;
  double volume = 0.0, substep_volume = 0.0;  // largest errors
  double deepest = 0.0;                       // m, nodes of the ball beyond its planes
};

Outcome run(const std::string& scene, const std::vector<std::string>& overrides, int frames) {
  Outcome out;
  out.model = build_model(read_scene(kPaper + scene, overrides));
  out.state = initial_state(out.model);
  Parallel one(1);
  StageSeconds seconds;
  for (int f = 1; f <= frames; ++f) {
    step_frame(out.model, f / out.model.fps, one, out.state, seconds);
    const Muscle& muscle = out.model.muscles[0];
    const MuscleState& now = out.state.muscles[0];
    out.volume = std::max(
        out.volume,
        std::abs(enclosed_volume(now.x, muscle.rest.triangles) / muscle.rest_volume - 1.0));
    out.substep_volume = std::max(out.substep_volume, now.substep_volume_error);
    if (scene != "ball.toml") continue;
    const double top = 0.1 - out.state.joints[find_body(out.model.skeleton, "top")];
    for (const Point& x : now.x) out.deepest = std::max(out.deepest, std::abs(x[1]) - top);
  }
  return out;
}

const std::vector<std::string> kSmall = {"muscle.ball.mesh=ball_1470.obj"};

std::vector<std::string> small_with(const std::string& setting) { return {kSmall[0], setting}; }

TEST(SoftBody, ABallBetweenPlanesKeepsItsVolumeAndStaysBetweenThem) {
  const Outcome exact = run("ball.toml", kSmall, 75);
  EXPECT_LE(exact.volume, 1e-12);
  EXPECT_GT(exact.substep_volume, 1e-9);  // linear within the frame
  EXPECT_LE(exact.deepest, 1e-12);
  const Outcome always = run("ball.toml", small_with("solver.volume=exact_always"), 40);
  EXPECT_LE(always.volume, 1e-12);
  EXPECT_LE(always.substep_volume, 1e-9);
  const Outcome none = run("ball.toml", small_with("solver.volume=none"), 40);
  EXPECT_GT(none.volume, 0.1);
}

TEST(SoftBody, ImplicitStepsKeepItToo) {
  const Outcome implicit = run("ball.toml", small_with("solver.integrator=local_global"), 40);
  EXPECT_LE(implicit.volume, 1e-12);
  EXPECT_LE(implicit.deepest, 2e-3);
}

TEST(SoftBody, HeldNodesGoWithTheirBodies) {
  const Outcome twisted = run("cube_twist.toml", {}, 30);  // by 90 degrees
  EXPECT_LE(twisted.volume, 1e-12);
  const Muscle& cube = twisted.model.muscles[0];
  int top = 0;
  for (size_t i = 0; i < cube.rest.vertices.size(); ++i) {
    const Vec3& rest = cube.rest.vertices[i];
    if (rest.y() < 0.0999) continue;
    ++top;
    const Vec3 turned(rest.z(), rest.y(), -rest.x());
    EXPECT_LT((to_vec(twisted.state.muscles[0].x[i]) - turned).norm(), 1e-12);
  }
  EXPECT_EQ(top, 9 * 9 + 8 * 8);
}

// The momentum of the free cow is the impulse that the ball gave it, although its weights are
// local.
TEST(SoftBody, LocalWeightsGiveAFreeBodyNoMomentum) {
  const Outcome cow = run("cow.toml", {}, 13);
  const Muscle& muscle = cow.model.muscles[0];
  const MuscleState& now = cow.state.muscles[0];
  EXPECT_GT(now.zone_radius, 0.0);
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Vec3 p = muscle.mass[i] * to_vec(now.v[i]);
    linear += p;
    angular += to_vec(now.x[i]).cross(p);
  }
  const double given = now.contact_impulse.impulse.norm();
  EXPECT_GT(given, 1e-3);
  EXPECT_LT((linear - now.contact_impulse.impulse).norm(), 1e-10 * given);
  EXPECT_LT((angular - now.contact_impulse.angular_impulse).norm(), 1e-10 * given);
  EXPECT_LE(cow.volume, 1e-12);
}

TEST(SoftBody, MistakesAreToldWithTheirPlace) {
  const auto message = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      build_model(read_scene(kPaper + "cube_twist.toml", overrides));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message({"muscle.cube.fixed.0.body=botom"}).find("did you mean \"bottom\""),
            std::string::npos);
  EXPECT_NE(message({"muscle.cube.fixed.0.high=[-9, -9, -9]"}).find("no node lies in the box"),
            std::string::npos);
  EXPECT_NE(message({"muscle.cube.fixed.0.high=[9, 9, 9]"}).find("that \"top\" holds"),
            std::string::npos);
  EXPECT_NE(message({"muscle.cube.material.shape=2"}).find("carried shape"), std::string::npos);
  EXPECT_NE(message({"muscle.cube.guide=250"}).find("guide"), std::string::npos);
}

}  // namespace
}  // namespace thew::tests
