// SPDX-License-Identifier: Apache-2.0
#include "skin/surface/surface.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

// The nearest point by testing all triangles one at a time, each with a tree of its own.
double brute_force(const Shape& shape, const Vec3& p) {
  double best = 1e9;
  for (const Triangle& t : shape.mesh.triangles) {
    const Vec3 a = shape.mesh.vertices[t[0]], b = shape.mesh.vertices[t[1]],
               c = shape.mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a).normalized();
    const Vec3 q = p - n.dot(p - a) * n;
    const bool within = (b - a).cross(q - a).dot(n) >= 0 && (c - b).cross(q - b).dot(n) >= 0 &&
                        (a - c).cross(q - c).dot(n) >= 0;
    if (within) best = std::min(best, (p - q).norm());
    const Vec3 corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      const Vec3 e = corners[(k + 1) % 3] - corners[k];
      const double s = std::clamp((p - corners[k]).dot(e) / e.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (p - corners[k] - s * e).norm());
    }
  }
  return best;
}

TEST(Surface, NeighboursOfACube) {
  const Shape box = make_shape(cube(1.0));
  for (int t = 0; t < 12; ++t) {
    for (int k = 0; k < 3; ++k) {
      const int across = box.surface.neighbours[t][k];
      ASSERT_GE(across, 0);
      std::set<int> shared(box.surface.triangles[t].begin(), box.surface.triangles[t].end());
      int common = 0;
      for (int node : box.surface.triangles[across]) common += shared.count(node);
      EXPECT_EQ(common, 2);
    }
  }
  EXPECT_NEAR(node_normal(box.surface, box.x, 7).dot(Vec3::Ones() / std::sqrt(3.0)), 1.0, 1e-12);
}

TEST(ClosestPoint, FaceEdgeAndCornerOfACube) {
  const Shape box = make_shape(cube(1.0));
  const auto distance = [&](const Vec3& p) {
    return closest_point(box.surface, box.bvh, box.x, p, 10.0).distance;
  };
  EXPECT_DOUBLE_EQ(distance({3, 0.1, 0.2}), 2.0);
  EXPECT_DOUBLE_EQ(distance({0.75, 0.1, 0.2}), -0.25);
  EXPECT_DOUBLE_EQ(distance({2, 2, 0}), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(distance({2, 2, 2}), std::sqrt(3.0));
  EXPECT_EQ(closest_point(box.surface, box.bvh, box.x, {3, 0, 0}, 1.9).triangle, -1);
  EXPECT_DOUBLE_EQ(closest_point(box.surface, box.bvh, box.x, {3, 0, 0}, 2.1, 0).distance, 2.0);
}

// Hints must not change the result, because a resumed bake has none. Tested on a rotated cube,
// where the two triangles of a side are equally near up to rounding, and on one that is not known
// to be convex.
TEST(ClosestPoint, AHintChangesNothing) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  TriMesh turned = cube(1.0);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& v : turned.vertices) v = turn * v + Vec3(0.1, 0.2, 0.3);
  Shape box = make_shape(turned);
  for (const bool convex : {true, false}) {
    box.surface.convex = convex;
    for (int i = 0; i < 4000; ++i) {
      // Over the diagonal of a side, off it by no more than rounding.
      const double along = coordinate(random), off = 1e-16 * (i % 9 - 4);
      const Vec3 p =
          turn * Vec3(along, along + off, 1.0 + std::abs(coordinate(random))) + Vec3(0.1, 0.2, 0.3);
      const ClosestPoint plain = closest_point(box.surface, box.bvh, box.x, p, 10.0);
      for (int hint = 0; hint < 12; ++hint) {
        const ClosestPoint hinted = closest_point(box.surface, box.bvh, box.x, p, 10.0, hint);
        ASSERT_EQ(hinted.triangle, plain.triangle) << "hint " << hint << " at " << along;
        ASSERT_EQ(hinted.distance, plain.distance);
        ASSERT_TRUE(std::equal(plain.barycentric, plain.barycentric + 3, hinted.barycentric));
      }
    }
  }
}

TEST(ClosestPoint, AgreesWithBruteForceAndKnownSides) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  const Shape ring = make_shape(torus(1.0, 0.4, 40, 24));
  const Shape box = make_shape(cube(1.0));
  int hint = -1;
  for (int i = 0; i < 400; ++i) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    const ClosestPoint on_box = closest_point(box.surface, box.bvh, box.x, p, 10.0);
    EXPECT_NEAR(std::abs(on_box.distance), brute_force(box, p), 1e-12);
    EXPECT_EQ(on_box.distance < 0.0, p.cwiseAbs().maxCoeff() < 1.0);
    const ClosestPoint on_ring = closest_point(ring.surface, ring.bvh, ring.x, p, 10.0, hint);
    EXPECT_NEAR(std::abs(on_ring.distance), brute_force(ring, p), 1e-12);
    EXPECT_NEAR((on_ring.point - p).norm(), std::abs(on_ring.distance), 1e-12);
    const double to_core = std::hypot(std::hypot(p.x(), p.y()) - 1.0, p.z());
    if (to_core < 0.38 || to_core > 0.4) {  // the facets lie between
      EXPECT_EQ(on_ring.distance < 0.0, to_core < 0.39);
    }
    hint = on_ring.triangle;
  }
}

TEST(ClosestPoint, HintChangesNothing) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  const Shape ring = make_shape(torus(1.0, 0.4, 40, 24));
  for (int i = 0; i < 200; ++i) {
    // On the planes of symmetry of the mesh, where many triangles are equally near.
    const Vec3 p(coordinate(random), 0.0, i % 2 ? 0.0 : coordinate(random));
    const ClosestPoint plain = closest_point(ring.surface, ring.bvh, ring.x, p, 10.0);
    const ClosestPoint hinted =
        closest_point(ring.surface, ring.bvh, ring.x, p, 10.0, (i * 37) % 1920);
    EXPECT_EQ(plain.triangle, hinted.triangle);
    EXPECT_EQ(plain.distance, hinted.distance);
  }
}

TEST(ClosestPoint, AConvexSurfaceIsDoneWithItsHintAlone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  EXPECT_FALSE(is_convex(make_shape(torus(1.0, 0.4, 40, 24)).surface,
                         to_points(torus(1.0, 0.4, 40, 24).vertices)));
  for (const TriMesh& mesh : {cube(1.0), ball(1.0, {0, 0, 0}, 16, 7)}) {
    const Shape plain = make_shape(mesh);
    Shape known = plain;
    known.surface.convex = is_convex(plain.surface, plain.x);
    ASSERT_TRUE(known.surface.convex);
    for (int i = 0; i < 400; ++i) {
      Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      if (i % 3 == 0) p.x() = 1.0;  // on a face of the cube, or beyond
      const ClosestPoint a = closest_point(plain.surface, plain.bvh, plain.x, p, 10.0);
      for (const int hint : {a.triangle, i % static_cast<int>(mesh.triangles.size())}) {
        const ClosestPoint b = closest_point(known.surface, known.bvh, known.x, p, 10.0, hint);
        EXPECT_EQ(a.triangle, b.triangle);
        EXPECT_EQ(a.distance, b.distance);
        EXPECT_EQ(a.normal, b.normal);
      }
    }
  }
}

TEST(Bvh, RefitHoldsAllAndEqualsARebuild) {
  Shape ring = make_shape(torus(1.0, 0.4, 40, 24));
  for (Point& p : ring.x) p = Point{p[0] + 10.0, 2.0 * p[1] - p[2], p[2] * p[0], 0.0};
  refit_bvh(ring.surface, ring.x, ring.bvh);
  const Bvh rebuilt = build_bvh(ring.surface, ring.x);
  for (const Bvh::Node& node : ring.bvh.nodes) {
    for (int i = node.first; i < node.first + node.count; ++i) {
      for (int corner : ring.surface.triangles[ring.bvh.order[i]]) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_LE(static_cast<double>(node.lo[k]), ring.x[corner][k]);
          EXPECT_GE(static_cast<double>(node.hi[k]), ring.x[corner][k]);
        }
      }
    }
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p(10.0 + coordinate(random), coordinate(random), coordinate(random));
    const ClosestPoint a = closest_point(ring.surface, ring.bvh, ring.x, p, 10.0);
    const ClosestPoint b = closest_point(ring.surface, rebuilt, ring.x, p, 10.0);
    EXPECT_EQ(a.triangle, b.triangle);
    EXPECT_EQ(a.distance, b.distance);
  }
}

TEST(Bvh, FewTrianglesAndNone) {
  const Shape box = make_shape(cube(1.0));
  EXPECT_EQ(build_bvh(box.surface, box.x).order.size(), 12u);
  const Shape none = make_shape(TriMesh{});
  EXPECT_EQ(closest_point(none.surface, none.bvh, none.x, Vec3::Zero(), 1.0).triangle, -1);
}

TEST(Crossing, KnownCases) {
  const auto pairs = [](const TriMesh& a, const TriMesh& b) {
    const Shape s = make_shape(a), t = make_shape(b);
    return crossing_triangles(s.surface, s.bvh, s.x, t.surface, t.bvh, t.x).size();
  };
  const TriMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const TriMesh through{{{0.2, 0.2, -1}, {0.2, 0.2, 1}, {2, 2, 0}}, {{0, 1, 2}}};
  const TriMesh touching{{{0.2, 0.2, 0}, {0.2, 0.2, 1}, {2, 2, 1}}, {{0, 1, 2}}};
  const TriMesh above{{{0, 0, 0.1}, {1, 0, 0.1}, {0, 1, 0.1}}, {{0, 1, 2}}};
  EXPECT_EQ(pairs(flat, through), 1u);
  EXPECT_EQ(pairs(through, flat), 1u);
  EXPECT_EQ(pairs(flat, touching), 0u);
  EXPECT_EQ(pairs(flat, above), 0u);
  EXPECT_EQ(pairs(flat, flat), 0u);  // coplanar
  EXPECT_EQ(pairs(ball(1.0, {0, 0, 0}, 20, 9), ball(1.0, {2.1, 0, 0}, 20, 9)), 0u);
  EXPECT_EQ(pairs(ball(1.0, {0, 0, 0}, 20, 9), ball(0.5, {0, 0, 0}, 20, 9)), 0u);
  EXPECT_GT(pairs(ball(1.0, {0, 0, 0}, 20, 9), ball(1.0, {0.71, 0.3, 0.2}, 20, 9)), 40u);
}

TEST(Crossing, OfASurfaceWithItself) {
  Shape ring = make_shape(torus(1.0, 0.4, 40, 24));
  const auto count = [&] {
    refit_bvh(ring.surface, ring.x, ring.bvh);
    return crossing_triangles(ring.surface, ring.bvh, ring.x, ring.surface, ring.bvh, ring.x)
        .size();
  };
  EXPECT_EQ(count(), 0u);
  // One node that is drawn through the tube and out of its far side makes triangles cross.
  ring.x[12] = Point{2.0, 0.05, 0.03, 0.0};
  EXPECT_GT(count(), 0u);
}

// What a solver that has diverged leaves has boxes without an extent: the search ends all the same.
TEST(Crossing, OfWhatIsNoNumberEnds) {
  Shape shape = make_shape(ball(1.0, {0, 0, 0}, 20, 9));
  for (const double no : {std::numeric_limits<double>::infinity(), std::nan("")}) {
    for (Point& p : shape.x) p = Point{no, no, no};
    refit_bvh(shape.surface, shape.x, shape.bvh);
    crossing_triangles(shape.surface, shape.bvh, shape.x, shape.surface, shape.bvh, shape.x);
  }
}

}  // namespace
}  // namespace thew::tests
