// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/unfolding.h"

#include <gtest/gtest.h>

#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kLongest = 7e-4;  // m, of a step

// A tube of which the middle ring has a node pressed in by so much (m).
struct Dented {
  Shape shape = make_shape(spindle(-0.05, 0.05, 20, 11, [](double, double) { return 0.01; }));
  std::vector<Vec3> rest = shape.mesh.vertices;
  std::vector<char> free = std::vector<char>(rest.size(), 1);
  int node = 1 + 20 * 5;
  FoldWork work;
  Parting parting;

  explicit Dented(double by) { press(shape.x, by); }
  void press(Points& x, double by) const {
    const double radius = std::hypot(x[node][0], x[node][2]);
    for (int k : {0, 2}) x[node][k] *= (radius - by) / radius;
  }
  Collider body() { return {&shape.surface, &shape.bvh, &shape.x, &free}; }
  size_t find() {
    find_folded_edges(body(), rest, work);
    return work.edges.size();
  }
  // The rounds until nothing is folded; 20 at most.
  int open() {
    int rounds = 0;
    for (; find() > 0 && rounds < 20; ++rounds) {
      begin_parting(body(), parting);
      push_open(body(), rest, work.edges, kLongest, parting);
      part(parting, shape.x);
    }
    return rounds;
  }
};

// Degrees, at the sharpest edge.
double sharpest(const Shape& shape, const Points& x) {
  double least = 1.0;
  for (int t = 0; t < static_cast<int>(shape.surface.triangles.size()); ++t) {
    for (const int other : shape.surface.neighbours[t]) {
      least = std::min(least,
                       face_normal(shape.surface, x, t).dot(face_normal(shape.surface, x, other)));
    }
  }
  return std::acos(least) * 180.0 / M_PI;
}

TEST(Unfolding, ADentIsOpenedToARightAngleByWhatIsNearIt) {
  Dented dent(0.009);
  const Points before = dent.shape.x;
  ASSERT_GT(sharpest(dent.shape, before), 95.0);
  EXPECT_LE(dent.open(), 12);
  EXPECT_LT(sharpest(dent.shape, dent.shape.x), 85.1);
  EXPECT_LT(largest_distance(dent.shape.x, before), 5e-3);
  EXPECT_EQ(norm(dent.shape.x[0] - before[0]), 0.0);  // a pole
}

TEST(Unfolding, AShallowDentIsLeft) {
  Dented dent(0.001);
  ASSERT_LT(sharpest(dent.shape, dent.shape.x), 85.0);
  EXPECT_EQ(dent.find(), 0u);
}

// As sharp as it was made: nothing to open, and no sharper than that.
TEST(Unfolding, AnEdgeMaySharpenToWhatItIsAtRest) {
  Dented dent(0.009);
  Points made = to_points(dent.rest);
  dent.press(made, 0.009);
  for (size_t i = 0; i < made.size(); ++i) dent.rest[i] = to_vec(made[i]);
  EXPECT_EQ(dent.find(), 0u);
}

TEST(Unfolding, WhatIsDrivenStays) {
  Dented dent(0.009);
  dent.free[dent.node] = 0;
  const Point before = dent.shape.x[dent.node];
  ASSERT_GT(dent.find(), 0u);
  dent.open();
  EXPECT_EQ(norm(dent.shape.x[dent.node] - before), 0.0);
  dent.free.assign(dent.free.size(), 0);
  EXPECT_EQ(dent.find(), 0u);
}

}  // namespace
}  // namespace thew::tests
