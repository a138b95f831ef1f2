// SPDX-License-Identifier: Apache-2.0
//
// A model from arrays: no file is read or written.
#include <gtest/gtest.h>

#include <cmath>

#include "muscles/tube.h"
#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/scene/build_model.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

// Two bodies in line along x, a hinge between them, and one muscle from the one to the other.
ModelDef upper_and_lower() {
  using Joint = Skeleton::JointType;
  ModelDef def;
  def.settle = 0.5;
  def.last_frame = 13;
  const auto add = [&](const char* name, int parent, double x, Joint type) {
    def.skeleton.body_names.push_back(name);
    def.skeleton.parent.push_back(parent);
    def.skeleton.joint_in_parent.push_back(Transform(Eigen::Translation3d(x, 0.0, 0.0)));
    def.skeleton.joint_names.push_back(parent < 0 ? "" : "hinge");
    def.skeleton.joint_types.push_back(type);
    def.skeleton.joint_axes.push_back(Vec3::UnitZ());
    def.skeleton.lower.push_back(-2.0);
    def.skeleton.upper.push_back(2.0);
    def.skeleton.visuals.emplace_back();
  };
  add("upper", -1, 0.0, Joint::kFixed);
  add("lower", 0, 0.3, Joint::kRevolute);
  def.clip.joints = {"hinge"};
  def.clip.times = {0.0, 0.5};
  def.clip.values = {{0.0}, {1.0}};
  MuscleDef& muscle = def.muscles.emplace_back();
  muscle.name = "flexor";
  muscle.path.points = {{0, Vec3(0.02, 0.03, 0.0)}, {1, Vec3(0.05, 0.03, 0.0)}};
  Pose rest;
  forward_kinematics(def.skeleton, {0.0, 0.0}, rest);
  muscle.mesh =
      make_tube(trace_path(muscle.path, rest), 12, 9, {{0.0, 0.004}, {0.5, 0.016}, {1.0, 0.004}});
  return def;
}

std::vector<Points> run(const ModelDef& def) {
  const Model model = build_model(def);
  State state = initial_state(model);
  Parallel one(1);
  StageSeconds seconds;
  settle(model, one, state);
  std::vector<Points> frames = {state.muscles[0].x};
  for (int frame = def.first_frame + 1; frame <= def.last_frame; ++frame) {
    step_frame(model, (frame - def.first_frame) / def.fps, one, state, seconds);
    frames.push_back(state.muscles[0].x);
  }
  return frames;
}

TEST(Definition, AMuscleBetweenTwoBodiesMovesAtItsVolume) {
  const ModelDef def = upper_and_lower();
  const std::vector<Points> frames = run(def);
  const std::vector<Triangle>& triangles = def.muscles[0].mesh.triangles;
  const double rest = enclosed_volume(def.muscles[0].mesh);
  for (const Points& x : frames) {
    EXPECT_NEAR(enclosed_volume(x, triangles) / rest, 1.0, 1e-12);
  }
  // The pole at the insertion goes with the lower body: a turn of 1 rad about the hinge.
  const Vec3 arm(0.05, 0.03, 0.0), hinge(0.3, 0.0, 0.0);
  const Vec3 there = hinge + rotation_about(Vec3::UnitZ(), 1.0) * arm;
  EXPECT_LT((to_vec(frames.back().back()) - there).norm(), 1e-9);
  // Shorter, it bulges: its middle is thicker than at rest.
  const auto thickness = [&](const Points& x) {
    double most = 0.0;
    const size_t ring = 1 + 4 * 12;  // the middle one, after a pole
    for (size_t k = 0; k < 6; ++k) most = std::max(most, norm(x[ring + k] - x[ring + k + 6]));
    return most;
  };
  EXPECT_GT(thickness(frames.back()), 1.05 * thickness(frames.front()));
}

TEST(Definition, WeightsByNodeMoveTheBulge) {
  ModelDef def = upper_and_lower();
  const std::vector<Points> even = run(def);
  for (const Vec3& p : def.muscles[0].mesh.vertices) {
    def.muscles[0].weights.push_back(p.x() < 0.18 ? 1.8 : 0.2);
  }
  EXPECT_GT(largest_distance(run(def).back(), even.back()), 5e-4);
  def.muscles[0].weights.assign(def.muscles[0].mesh.vertices.size(), 3.0);  // of any unit
  EXPECT_LT(largest_distance(run(def).back(), even.back()), 1e-12);
}

TEST(Definition, ArraysThatDoNotFitAreRefusedByName) {
  const auto refusal = [](const auto& spoil) {
    ModelDef def = upper_and_lower();
    spoil(def.muscles[0]);
    try {
      build_model(def);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("muscle \"flexor\""), std::string::npos) << text;
  };
  has(refusal([](MuscleDef& of) {
        of.weights = {1.0, 2.0};
      }),
      "weights has 2 values for a mesh of");
  has(refusal([](MuscleDef& of) { of.path.points[1].body = 7; }), "a body beyond the skeleton's 2");
  has(refusal([](MuscleDef& of) { of.path.points.pop_back(); }), "its path has one point");
  has(refusal([](MuscleDef& of) { of.mesh.triangles[0][1] = 4000; }), "names vertex 4000 of");
  has(refusal([](MuscleDef& of) { of.mesh = {}; }), "its mesh is empty");
  has(refusal([](MuscleDef& of) { of.twist_from = 9.0; }), "twist_from lies beyond the path");
}

}  // namespace
}  // namespace thew::tests
