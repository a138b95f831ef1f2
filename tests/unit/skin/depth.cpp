// SPDX-License-Identifier: Apache-2.0
#include "skin/depth.h"

#include <gtest/gtest.h>

#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

bool inside(const Shape& shape, const Vec3& p) {
  return encloses(shape.surface, shape.bvh, shape.x, p);
}

double depth(const Shape& shape, const Vec3& p) {
  return deepest_inside(shape.surface, shape.bvh, shape.x, {to_point(p)});
}

Vec3 anywhere(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> along(-reach, reach);
  return {along(random), along(random), along(random)};
}

// A ball every seventh corner of which is turned through its middle.
TriMesh tangled() {
  std::mt19937 random(3);
  TriMesh mesh = ball(1.0, Vec3::Zero(), 24, 23);
  for (size_t i = 0; i < mesh.vertices.size(); i += 7) mesh.vertices[i] *= -0.6;
  for (Vec3& p : mesh.vertices) p += 1e-3 * anywhere(random, 1.0);
  return mesh;
}

TEST(Depth, InsideIsWhatTheSurfaceGoesRound) {
  std::mt19937 random(1);
  int in = 0, out = 0;
  for (const TriMesh& mesh : {ball(1.0, Vec3(0.1, 0, 0), 24, 23), torus(1.0, 0.4, 24, 12),
                              torus(0.3, 0.6, 24, 12), tangled(), cube(0.7)}) {
    const Shape shape = make_shape(mesh);
    for (int k = 0; k < 4000; ++k) {
      const Vec3 p = anywhere(random, 1.2);
      const bool expected = std::abs(winding_number(shape.surface, shape.x, p)) > 0.5;
      ASSERT_EQ(inside(shape, p), expected) << p.transpose();
      ++(expected ? in : out);
    }
  }
  EXPECT_GT(in, 2000);
  EXPECT_GT(out, 2000);
}

// Each ray meets edges or corners, and one of them only touches.
TEST(Depth, ARayThroughEdgesAndCornersCountsOnce) {
  const Shape box = make_shape(cube(1.0)), round = make_shape(ball(1.0, Vec3::Zero(), 24, 23));
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      for (int k = -2; k <= 2; ++k) {
        const Vec3 p = 0.45 * Vec3(i, j, k), far = 2.5 * p;
        EXPECT_TRUE(inside(box, p)) << p.transpose();
        EXPECT_EQ(inside(box, far), far.isZero()) << far.transpose();
        EXPECT_EQ(inside(round, p), p.norm() < 0.95) << p.transpose();
      }
    }
  }
  for (const Vec3& corner : round.mesh.vertices) {
    EXPECT_TRUE(inside(round, 0.9 * corner));
    EXPECT_FALSE(inside(round, 1.1 * corner));
  }
}

// A ray that leaves through the hole has another count than the others.
TEST(Depth, AHoleDecidesNothing) {
  TriMesh mesh = ball(1.0, Vec3::Zero(), 24, 23);
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return mesh.vertices[t[0]].y() > 0.95; });
  const Shape cup = make_shape(mesh);
  for (const double y : {-0.9, -0.5, 0.0, 0.5, 0.8}) EXPECT_TRUE(inside(cup, Vec3(0, y, 0))) << y;
  for (const double y : {-1.1, 1.05, 1.5}) EXPECT_FALSE(inside(cup, Vec3(0, y, 0))) << y;
}

// A search with a bound would report such depths as 0 or as the bound.
TEST(Depth, IsTheTrueOneHoweverDeep) {
  const Shape box = make_shape(cube(0.7));
  EXPECT_NEAR(depth(box, Vec3(0.1, 0, 0)), 0.6, 1e-15);
  EXPECT_EQ(depth(box, Vec3(0.71, 0, 0)), 0.0);
  const auto outside = [&](const Vec3& p) {
    return farthest_outside(box.surface, box.bvh, box.x, {to_point(p)});
  };
  EXPECT_NEAR(outside(Vec3(0, 1.9, 0)), 1.2, 1e-15);
  EXPECT_EQ(outside(Vec3(0, 0.6, 0)), 0.0);
}

// A fin of no thickness sticks out of a face: points beside it are outside, whatever its normals
// are.
TEST(Depth, NoNormalIsAsked) {
  TriMesh mesh = cube(0.7);
  const int tip = 8, foot = 9;
  mesh.vertices.emplace_back(1.0, 0.0, 0.0);
  mesh.vertices.emplace_back(1.0, 0.0, 0.0);
  mesh.triangles.push_back({1, tip, foot});
  mesh.triangles.push_back({1, foot, tip});
  mesh.vertices[foot] += Vec3(0, 1e-9, 1e-9);
  const Shape shape = make_shape(mesh);
  std::mt19937 random(5);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 p = Vec3(1.0, 0, 0) + anywhere(random, 0.2);
    EXPECT_EQ(depth(shape, p), 0.0) << p.transpose();
  }
}

}  // namespace
}  // namespace thew::tests
