// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/skin/shapes.h"
#include "tools/inspect/crossings.h"
#include "tools/inspect/exact_predicates.h"

namespace thew::tests {
namespace {

using Kind = BakeMesh::Kind;
const Corners kFlat = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};

auto crossings_of(const TriMesh& a, Kind kind_a, const TriMesh& b, Kind kind_b) {
  return find_crossings({{"a", kind_a, a, {}, {}}, {"b", kind_b, b, {}, {}}},
                        {a.vertices, b.vertices});
}

TriMesh moved(TriMesh mesh, const Vec3& by) {
  for (Vec3& p : mesh.vertices) p += by;
  return mesh;
}

const TriMesh kTetrahedron{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};

TEST(ExactPredicates, OneUnitInTheLastPlaceIsSeen) {
  const Vec3 a(0.1, 0.1, 0.1), b(0.3, 0.3, 0.3), c(0.7, 0.1, 0.3), d(0.5, 0.5, 0.5);
  // a, b and d lie on x = y = z only where 0.1, 0.3 and 0.5 are the same double in each place.
  EXPECT_EQ(orientation(a, b, c, d), 0);
  Vec3 up = d, down = d;
  up.z() = std::nextafter(0.5, 1.0), down.z() = std::nextafter(0.5, 0.0);
  EXPECT_EQ(orientation(a, b, c, up) * orientation(a, b, c, down), -1);
  EXPECT_EQ(orientation(a, b, c, up), -orientation(b, a, c, up));
}

// On integers of 20 bits the determinant is exact in 128.
TEST(ExactPredicates, AgreesWithIntegers) {
  std::mt19937 random(1);
  for (int round = 0; round < 20000; ++round) {
    long v[4][3];
    Vec3 p[4];
    const long size = round % 2 ? 3 : 1 << 20;  // the small ones are often in one plane
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 3; ++k) p[i][k] = v[i][k] = static_cast<long>(random() % size);
    }
    __int128 m[3][3], det = 0;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) m[i][k] = v[i + 1][k] - v[0][k];
    }
    for (int k = 0; k < 3; ++k) {
      const int x = (k + 1) % 3, y = (k + 2) % 3;
      det += m[0][k] * (m[1][x] * m[2][y] - m[1][y] * m[2][x]);
    }
    ASSERT_EQ(orientation(p[0], p[1], p[2], p[3]), det > 0 ? 1 : (det < 0 ? -1 : 0));
  }
}

TEST(TrianglesMeet, ByHand) {
  const auto meet = [](const Corners& t) {
    EXPECT_EQ(triangles_meet(kFlat, t), triangles_meet(t, kFlat));
    return triangles_meet(kFlat, t);
  };
  EXPECT_TRUE(meet({Vec3(0.2, 0.2, -1), Vec3(0.2, 0.2, 1), Vec3(3, 3, 0)})) << "through";
  EXPECT_FALSE(meet({Vec3(0.6, 0.6, -1), Vec3(0.6, 0.6, 1), Vec3(3, 3, 0)})) << "beside";
  EXPECT_TRUE(meet({Vec3(0.2, 0.2, 0), Vec3(0, 0, 1), Vec3(1, 0, 1)})) << "touching";
  EXPECT_FALSE(meet({Vec3(0.2, 0.2, 1e-300), Vec3(0, 0, 1), Vec3(1, 0, 1)})) << "just not";
  EXPECT_TRUE(meet({Vec3(0.1, 0.1, 0), Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)})) << "one in it";
  EXPECT_TRUE(meet({Vec3(-1, 0.5, 0), Vec3(2, 0.5, 0), Vec3(2, 0.6, 0)})) << "coplanar";
  EXPECT_FALSE(meet({Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(2, 1, 0)})) << "coplanar, apart";
  EXPECT_TRUE(meet({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 1)})) << "a common edge";
  EXPECT_TRUE(meet({Vec3(0.2, 0.2, -1), Vec3(0.2, 0.2, 0.5), Vec3(0.2, 0.2, 1)})) << "needle";
  EXPECT_FALSE(meet({Vec3(2, 2, -1), Vec3(2, 2, 0.5), Vec3(2, 2, 1)})) << "needle beside";
}

// The second one's corner, at the origin of its own axes, lies inside the first.
TEST(Crossings, TetrahedraInEachOther) {
  const TriMesh second = moved(kTetrahedron, Vec3(0.2, 0.2, 0.2));
  const auto found = crossings_of(kTetrahedron, Kind::kMuscle, second, Kind::kMuscle);
  // Three faces at that corner pass through the slanted face of the first, and nothing else does.
  EXPECT_EQ(found[1].pairs, 3);
  EXPECT_NEAR(found[1].depth, 0.2, 1e-15);  // to the faces x = 0, y = 0, z = 0
  EXPECT_EQ(found[1].deep_vertex, 0);
  for (const int other : {0, 2, 3, 4}) EXPECT_EQ(found[other].pairs, 0);
  const TriMesh away = moved(kTetrahedron, Vec3(0.4, 0.4, 0.4));
  const auto none = crossings_of(kTetrahedron, Kind::kMuscle, away, Kind::kMuscle);
  EXPECT_EQ(none[1].pairs, 0);
  EXPECT_EQ(none[1].depth, 0.0);
}

// Away from their poles, which are attached and look along y.
TEST(Crossings, BallsAsDeepAsTheyOverlap) {
  const TriMesh a = ball(1.0, Vec3(0, 0, 0), 48, 47), b = ball(1.0, Vec3(1.9, 0.01, 0), 48, 47);
  const auto found = crossings_of(a, Kind::kMuscle, b, Kind::kBone);
  EXPECT_GT(found[0].pairs, 20);
  EXPECT_EQ(found[0].attached, 0);
  EXPECT_NEAR(found[0].depth, 0.1, 0.005);
  const auto skin = crossings_of(a, Kind::kMuscle, ball(1.2, Vec3(0.3, 0, 0), 48, 47), Kind::kSkin);
  EXPECT_NEAR(skin[2].depth, 0.1, 0.005) << "the muscle's side looks out of the skin";
  const auto in = crossings_of(a, Kind::kMuscle, ball(1.2, Vec3(0, 0, 0), 48, 47), Kind::kSkin);
  EXPECT_EQ(in[2].pairs, 0);
  EXPECT_EQ(in[2].depth, 0.0);
}

// In a muscle of any size.
TEST(Crossings, WhereATendonEntersItsBoneIsCountedApart) {
  for (const double size : {1.0, 0.1, 3.0}) {
    const auto bone = [&](double radius, double y) {
      return ball(size * radius, Vec3(0, size * y, 0), 24, 23);
    };
    const TriMesh muscle = spindle(0.0, 0.2 * size, 16, 40, [&](double y, double) {
      return size * 0.002 + 0.1 * y * (0.2 - y / size);
    });
    const auto at_end = crossings_of(muscle, Kind::kMuscle, bone(0.006, 0.0), Kind::kBone);
    EXPECT_EQ(at_end[0].pairs, 0);
    EXPECT_GT(at_end[0].attached, 0);
    EXPECT_EQ(at_end[0].depth, 0.0);
    // By where they cross, however far the triangles reach: rings a quarter of the length apart.
    const TriMesh coarse =
        spindle(0.0, 0.2 * size, 16, 4, [&](double, double) { return 0.002 * size; });
    const double reach = kAttachmentReach * std::cbrt(enclosed_volume(coarse)) / size;
    for (const double share : {0.9, 1.1}) {
      const auto found = crossings_of(coarse, Kind::kMuscle, bone(share * reach, 0.0), Kind::kBone);
      EXPECT_EQ(found[0].attached > 0, share < 1.0) << share;
      EXPECT_EQ(found[0].pairs > 0, share > 1.0) << share;
    }
    const auto in_belly = crossings_of(muscle, Kind::kMuscle, bone(0.008, 0.1), Kind::kBone);
    EXPECT_EQ(in_belly[0].attached, 0);
    EXPECT_GT(in_belly[0].pairs + in_belly[0].depth, 0);
  }
}

TEST(Crossings, AHeapIsNamedAndNotCounted) {
  TriMesh heap = cube(1.0);
  for (const double at : {0.0, 5e-324, 1e-310, 0.7}) {
    for (Vec3& p : heap.vertices) p = Vec3::Constant(at);
    try {
      crossings_of(cube(1.0), Kind::kMuscle, heap, Kind::kMuscle);
      ADD_FAILURE() << "all in " << at;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      EXPECT_EQ(std::string(error.what()).find("all nodes of b lie in one place"), 0u);
    }
  }
}

TEST(Crossings, AMeshWithItselfLeavesNeighboursOut) {
  const TriMesh whole = torus(1.0, 0.3, 24, 12), folded = torus(0.2, 0.3, 24, 12);
  const TriMesh far = moved(kTetrahedron, Vec3(9, 9, 9));
  EXPECT_EQ(crossings_of(whole, Kind::kSkin, far, Kind::kBone)[4].pairs, 0);
  EXPECT_GT(crossings_of(folded, Kind::kSkin, far, Kind::kBone)[4].pairs, 0);
}

// The sweep finds what all against all finds, on a grid coarse enough to touch often.
TEST(Crossings, AgreesWithAllAgainstAll) {
  std::mt19937 random(2);
  for (const int grid : {4, 1 << 20}) {
    TriMesh soups[2];
    for (TriMesh& soup : soups) {
      for (int t = 0; t < 150; ++t) {
        const Vec3 centre = Vec3(random() % 100, random() % 100, random() % 100) / 50.0;
        for (int i = 0; i < 3; ++i) {
          const Vec3 corner = Vec3(random() % grid, random() % grid, random() % grid) / grid;
          soup.vertices.push_back(centre + corner);
        }
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
      }
    }
    int expected = 0;
    for (const Triangle& s : soups[0].triangles) {
      for (const Triangle& t : soups[1].triangles) {
        const auto &x = soups[0].vertices, &y = soups[1].vertices;
        expected += triangles_meet({x[s[0]], x[s[1]], x[s[2]]}, {y[t[0]], y[t[1]], y[t[2]]});
      }
    }
    EXPECT_GT(expected, 100);
    EXPECT_EQ(crossings_of(soups[0], Kind::kSkin, soups[1], Kind::kBone)[3].pairs, expected);
  }
}

}  // namespace
}  // namespace thew::tests
