// SPDX-License-Identifier: Apache-2.0
#include "skin/flesh_field.h"

#include <gtest/gtest.h>

#include <random>

#include "skin/flesh_level.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

// As a muscle's flat origin behind a folded elbow: its upper third is flat and lies back on itself.
TriMesh folded_muscle() {
  TriMesh mesh = spindle(-0.03, 0.03, 16, 21, [](double, double) { return 0.008; });
  for (Vec3& p : mesh.vertices) {
    const double above = p.y() - 0.01;
    if (above > 0.0) p = Vec3(0.1 * p.x() + 0.3 * above, 0.01 - 0.4 * above, p.z());
  }
  return mesh;
}

// The nearest normal of such a surface does not tell the side that a point is on.
TEST(FleshField, WhatIsOutsideOfAFoldedSurfaceIsNotTakenForInside) {
  const Shape shape = make_shape(folded_muscle());
  const std::vector<Collider> below{
      {&shape.surface, &shape.bvh, &shape.x, nullptr, nullptr, box_of(shape.x)}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(-0.04, 0.04);
  int outside = 0, turned = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const Vec3 p(along(random), along(random), along(random));
    if (std::abs(winding_number(shape.surface, shape.x, p)) > 0.5) continue;
    ++outside;
    const ClosestPoint near = closest_point(shape.surface, shape.bvh, shape.x, p, 0.1);
    turned += near.distance < 0.0;
    FleshPlanes planes{std::vector<std::array<FleshPlanes::Plane, FleshPlanes::kMaxPlanes>>(1),
                       {0}};
    std::vector<int> hints(2, -1);
    find_flesh(below, {to_point(p)}, {1, {0}}, 0.1, 0.012, 1e-7, hints, planes);
    const FleshValue flesh = nearest_flesh(planes, 0, p);
    ASSERT_TRUE(flesh.found);
    EXPECT_NEAR(flesh.nearest, std::abs(near.distance), 1e-12) << p.transpose();
    // The way out leads away from the surface.
    EXPECT_GT(flesh.normal_of_nearest.dot(p - near.point), 0.0) << p.transpose();
  }
  EXPECT_GT(outside, 10000);
  EXPECT_GT(turned, 0) << "the shape is none that normals are wrong about";
  std::printf("%d points outside, %d of them inside by the nearest normal\n", outside, turned);
}

}  // namespace
}  // namespace thew::tests
