// SPDX-License-Identifier: Apache-2.0
//
// The skins of two balls of flesh that are moved into each other.
#include <gtest/gtest.h>

#include "skin/skin_layer.h"
#include "skin/skin_passes.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kApart = 0.25;  // m, of the balls at rest

TriMesh two_balls(double radius) {
  TriMesh mesh = ball(radius, Vec3::Zero(), 32, 31);
  const TriMesh second = ball(radius, Vec3(kApart, 0, 0), 32, 31);
  const int nodes = static_cast<int>(mesh.vertices.size());
  for (const Triangle& t : second.triangles) {
    mesh.triangles.push_back({t[0] + nodes, t[1] + nodes, t[2] + nodes});
  }
  mesh.vertices.insert(mesh.vertices.end(), second.vertices.begin(), second.vertices.end());
  return mesh;
}

struct TwoBalls {
  Shape flesh = make_shape(two_balls(0.09));
  SkinModel model;
  SkinState state;

  std::vector<Collider> below() const { return {{&flesh.surface, &flesh.bvh, &flesh.x, nullptr}}; }
  // The second ball and its skin moved by this (m) towards the first.
  explicit TwoBalls(double by) {
    Skeleton skeleton;
    skeleton.body_names = {"bone"};
    skeleton.parent = {-1};
    const Pose pose = {Transform::Identity()};
    model = bind_skin(two_balls(0.1), skeleton, pose, below(), {0}, {});
    state = initial_skin(model);
    step_skin(model, pose, below(), {}, state);
    for (Points* points : {&state.x, &flesh.x}) {
      for (size_t i = points->size() / 2; i < points->size(); ++i) (*points)[i][0] -= by;
    }
    refit_bvh(flesh.surface, flesh.x, flesh.bvh);
  }
  int crossings() const {
    const Bvh bvh = build_bvh(model.surface, state.x);
    const auto pairs = crossing_triangles(model.surface, bvh, state.x, model.surface, bvh, state.x);
    return static_cast<int>(pairs.size());
  }
};

TEST(Untangle, PartsWhatLiesFlatInEachOther) {
  for (const double by : {0.051, 0.055}) {
    TwoBalls balls(by);
    EXPECT_GT(balls.crossings(), 20);
    untangle(balls.model, balls.below(), balls.state);
    EXPECT_EQ(balls.crossings(), 0) << by << " m";
  }
}

TEST(Untangle, LeavesNoMoreCrossingsThanItFound) {
  // The balls themselves overlap, and between them is no room for two skins.
  for (const double by : {0.09, 0.17, 0.21, 0.24}) {
    TwoBalls balls(by);
    const int before = balls.crossings();
    untangle(balls.model, balls.below(), balls.state);
    EXPECT_GT(balls.crossings(), 0);
    EXPECT_LE(balls.crossings(), before) << by << " m";
  }
}

}  // namespace
}  // namespace thew::tests
