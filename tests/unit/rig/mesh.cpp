// SPDX-License-Identifier: Apache-2.0
#include "rig/mesh.h"

#include <gtest/gtest.h>

#include "tests/unit/rig/shapes.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

const Defect* find(const std::vector<Defect>& defects, Defect::Kind kind) {
  for (const Defect& d : defects) {
    if (d.kind == kind) return &d;
  }
  return nullptr;
}

// The only defect of the mesh, which must be of this kind.
Defect only(const TriMesh& mesh, Defect::Kind kind) {
  const auto defects = find_defects(mesh);
  EXPECT_EQ(defects.size(), 1u);
  for (const Defect& d : defects) EXPECT_EQ(d.kind, kind) << defect_name(d.kind) << d.where;
  return defects.empty() ? Defect{} : defects[0];
}

TEST(EnclosedVolume, CubeIsOne) { EXPECT_EQ(enclosed_volume(unit_cube()), 1.0); }

TEST(EnclosedVolume, ShiftedOriginAndTurnedWinding) {
  TriMesh cube = unit_cube();
  for (Vec3& p : cube.vertices) p += Vec3(1000.0, -2000.0, 500.0);
  EXPECT_NEAR(enclosed_volume(cube), 1.0, 1e-15);
  for (Triangle& t : cube.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(enclosed_volume(cube), -1.0, 1e-15);
  EXPECT_EQ(enclosed_volume({}), 0.0);
}

TEST(VertexNormals, CubeCornersPointOutward) {
  const TriMesh cube = unit_cube();
  const auto normals = vertex_normals(cube);
  for (int v = 0; v < 8; ++v) {
    EXPECT_NEAR(normals[v].norm(), 1.0, 1e-15);
    EXPECT_GT(normals[v].dot(cube.vertices[v] - Vec3(0.5, 0.5, 0.5)), 0.0) << v;
  }
}

TEST(Weld, SeamSplitCylinderCloses) {
  const TriMesh split = split_cylinder(24);
  EXPECT_NE(find(find_defects(split), Defect::kOpenEdge), nullptr);
  const WeldResult welded = weld(split);
  EXPECT_EQ(welded.mesh.vertices.size(), 50u);
  EXPECT_EQ(welded.mesh.triangles.size(), split.triangles.size());
  EXPECT_TRUE(find_defects(welded.mesh).empty());
  for (size_t i = 0; i < split.vertices.size(); ++i) {
    EXPECT_EQ(welded.mesh.vertices[welded.map_back[i]], split.vertices[i]);
  }
  // regular 24-gon: area n/2 r^2 sin(2 pi / n)
  EXPECT_NEAR(enclosed_volume(welded.mesh), 0.5 * 12.0 * 0.01 * std::sin(M_PI / 12.0), 1e-15);
}

TEST(Weld, FirstAppearanceOrderZeroSignsAndCollapsedTriangles) {
  TriMesh mesh;
  mesh.vertices = {{1, 0, 0}, {0.0, 1, 0}, {1, 0, 0}, {-0.0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 4}, {0, 2, 4}, {2, 3, 4}};
  const WeldResult welded = weld(mesh);
  EXPECT_EQ(welded.map_back, (std::vector<int>{0, 1, 0, 1, 2}));
  EXPECT_EQ(welded.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}}));
}

TEST(FindDefects, SoundCubeHasNone) { EXPECT_TRUE(find_defects(unit_cube()).empty()); }

TEST(FindDefects, MissingTriangleLeavesThreeOpenEdges) {
  TriMesh cube = unit_cube();
  cube.triangles.erase(cube.triangles.begin() + 11);  // 3, 7, 5
  const Defect d = only(cube, Defect::kOpenEdge);
  EXPECT_EQ(d.count, 3);
  EXPECT_EQ(d.where, "edge 3-5 at (1, 0.5, 0.5)");
  EXPECT_FALSE(d.fix.empty());
}

TEST(FindDefects, NotFinite) {
  TriMesh cube = unit_cube();
  cube.vertices[6].y() = std::nan("");
  const Defect d = only(cube, Defect::kNotFinite);
  EXPECT_EQ(d.count, 1);
  EXPECT_HAS(d.where, "vertex 6 at (0, no number, 1)");
}

TEST(FindDefects, IndexOutOfRange) {
  TriMesh cube = unit_cube();
  cube.triangles[2][1] = 8;
  cube.triangles[5][0] = -1;
  const Defect d = only(cube, Defect::kIndexOutOfRange);
  EXPECT_EQ(d.count, 2);
  EXPECT_EQ(d.where, "triangle 2 names vertex 8 of 8");
}

TEST(FindDefects, NonManifoldEdge) {
  TriMesh cube = unit_cube();  // a fin on edge 0-1
  cube.vertices.emplace_back(0.5, -1, -1);
  cube.triangles.push_back({0, 1, 8});
  const auto defects = find_defects(cube);
  const Defect* d = find(defects, Defect::kNonManifoldEdge);
  ASSERT_NE(d, nullptr);
  EXPECT_EQ(d->count, 1);
  EXPECT_EQ(d->where, "edge 0-1 at (0.5, 0, 0)");
  EXPECT_EQ(find(defects, Defect::kOpenEdge)->count, 2);
}

TEST(FindDefects, NonManifoldVertex) {
  TriMesh pair = unit_cube();  // two cubes that share corner 7
  const TriMesh cube = unit_cube();
  std::vector<int> map;
  for (const Vec3& p : cube.vertices) {
    map.push_back(p.isZero() ? 7 : static_cast<int>(pair.vertices.size()));
    if (!p.isZero()) pair.vertices.push_back(p + Vec3::Ones());
  }
  for (const Triangle& t : cube.triangles)
    pair.triangles.push_back({map[t[0]], map[t[1]], map[t[2]]});
  const Defect d = only(pair, Defect::kNonManifoldVertex);
  EXPECT_EQ(d.count, 1);
  EXPECT_EQ(d.where, "vertex 7 at (1, 1, 1)");
}

TEST(FindDefects, InconsistentWinding) {
  TriMesh cube = unit_cube();
  std::swap(cube.triangles[0][0], cube.triangles[0][1]);  // 0, 2, 1
  const Defect d = only(cube, Defect::kInconsistentWinding);
  EXPECT_EQ(d.count, 3);
  EXPECT_EQ(d.where, "edge 0-1 at (0.5, 0, 0)");
}

TEST(FindDefects, InsideOut) {
  TriMesh cube = unit_cube();
  for (Triangle& t : cube.triangles) std::swap(t[0], t[1]);
  const Defect d = only(cube, Defect::kInsideOut);
  EXPECT_EQ(d.where, "vertex 2 at (0, 1, 0), volume -1 m^3");
}

TEST(FindDefects, SecondComponentInsideOut) {
  TriMesh pair = unit_cube();
  for (const Vec3& p : unit_cube().vertices) pair.vertices.push_back(0.25 * p + Vec3(1.5, 0, 0));
  for (const Triangle& t : unit_cube().triangles) {
    pair.triangles.push_back({t[1] + 8, t[0] + 8, t[2] + 8});
  }
  const auto defects = find_defects(pair);
  ASSERT_EQ(defects.size(), 2u);
  EXPECT_EQ(find(defects, Defect::kSeveralComponents)->count, 2);
  const Defect* d = find(defects, Defect::kInsideOut);
  ASSERT_NE(d, nullptr);
  EXPECT_EQ(d->count, 1);
  EXPECT_HAS(d->where, "component 2 of 2, vertex 10 at (1.5, 0.25, 0), volume -0.015625");
}

TEST(FindDefects, ZeroArea) {
  TriMesh cube = unit_cube();  // edge 1-2 gains a middle vertex, and a flat triangle on it
  cube.vertices.emplace_back(0.5, 0.5, 0.0);
  cube.triangles[0] = {0, 2, 8};
  cube.triangles.push_back({0, 8, 1});
  cube.triangles.push_back({8, 2, 1});
  const Defect d = only(cube, Defect::kZeroArea);
  EXPECT_EQ(d.count, 1);
  EXPECT_HAS(d.where, "triangle 13");
}

TEST(FindDefects, TriangleNamingAVertexTwice) {
  TriMesh cube = unit_cube();
  cube.triangles.push_back({3, 3, 5});
  EXPECT_EQ(only(cube, Defect::kZeroArea).count, 1);
}

TEST(FindDefects, UnusedVertex) {
  TriMesh cube = unit_cube();
  cube.vertices.emplace_back(0.5, 0.5, 0.5);
  EXPECT_EQ(only(cube, Defect::kUnusedVertex).where, "vertex 8 at (0.5, 0.5, 0.5)");
}

TEST(FindDefects, WrongScaleGuessesTheUnit) {
  const auto scaled = [](double factor) {
    TriMesh cube = unit_cube();
    for (Vec3& p : cube.vertices) p = factor * Vec3(p.x(), 2.71 * p.y(), p.z());
    return cube;
  };
  EXPECT_HAS(only(scaled(100.0), Defect::kWrongScale).where, "looks like millimetres: 271 m tall");
  EXPECT_HAS(only(scaled(10.0), Defect::kWrongScale).where, "looks like centimetres: 27.1 m tall");
  EXPECT_HAS(only(scaled(1e-4), Defect::kWrongScale).fix, "times 1000");
  EXPECT_EQ(only(scaled(1e9), Defect::kWrongScale).where, "2.71e+09 m tall (y)");
  EXPECT_TRUE(find_defects(scaled(100.0), {.smallest = 1.0, .largest = 1000.0}).empty());
}

TEST(FindDefects, EmptyMeshIsNotSound) { only({}, Defect::kWrongScale); }

}  // namespace
}  // namespace thew::tests
