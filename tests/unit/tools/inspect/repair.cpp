// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/repair.h"

#include <gtest/gtest.h>

#include "rig/import/mesh_import.h"
#include "rig/math.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

TriMesh cube() {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(Repair, LeavesASoundMeshAlone) {
  TriMesh mesh = cube();
  EXPECT_EQ(all(repair(mesh)), "");
  EXPECT_EQ(mesh.triangles, cube().triangles);
  EXPECT_NEAR(enclosed_volume(mesh), 1.0, 1e-15);
}

TEST(Repair, TurnsTrianglesAndParts) {
  TriMesh one = cube();
  std::swap(one.triangles[3][0], one.triangles[3][1]);
  EXPECT_HAS(all(repair(one)), "turned 1 triangles to one winding");
  EXPECT_TRUE(find_defects(one).empty());
  TriMesh inside_out = cube();
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_HAS(all(repair(inside_out)), "turned 1 parts outward");
  EXPECT_NEAR(enclosed_volume(inside_out), 1.0, 1e-15);
}

TEST(Repair, FillsSmallHolesAndNoLargeOnes) {
  TriMesh mesh = cube();
  mesh.triangles.resize(10);
  EXPECT_HAS(all(repair(mesh)), "filled a hole of 4 edges");
  EXPECT_TRUE(find_defects(mesh).empty());
  EXPECT_NEAR(enclosed_volume(mesh), 1.0, 1e-15);
  TriMesh ring;  // of 20 edges at either end
  for (int i = 0; i < 20; ++i) {
    const Vec3 p = rotation_about(Vec3::UnitZ(), 0.1 * i * kPi) * Vec3(1, 0, 0);
    ring.vertices.push_back(p);
    ring.vertices.push_back(p + Vec3(0, 0, 1));
    const int a = 2 * i, b = 2 * ((i + 1) % 20);
    ring.triangles.push_back({a, b, a + 1});
    ring.triangles.push_back({b, b + 1, a + 1});
  }
  EXPECT_EQ(all(repair(ring)), "");
  EXPECT_EQ(find_defects(ring)[0].kind, Defect::kOpenEdge);
}

TEST(Repair, JoinsNearVerticesAtOpenEdgesAndDropsDirt) {
  TriMesh mesh = cube();
  mesh.vertices.push_back(mesh.vertices[7] + Vec3(2e-7, 0, 0));
  mesh.triangles[11] = {3, 8, 5};
  mesh.vertices.emplace_back(5, 5, 5);
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.push_back({1, 1, 2});
  const std::string done = all(repair(mesh));
  EXPECT_HAS(done, "joined 1 vertices");
  EXPECT_HAS(done, "dropped 1 triangles without area");
  EXPECT_HAS(done, "dropped 1 triangles that were there twice");
  EXPECT_HAS(done, "dropped 2 vertices in no triangle");
  EXPECT_TRUE(find_defects(mesh).empty());
}

class RepairFile : public TempFolder {};

TEST_F(RepairFile, WritesWhatItRead) {
  const auto in =
      write("in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  EXPECT_HAS(all(repair_file(in, folder / "out.obj")), "filled a hole of 3 edges");
  EXPECT_NEAR(enclosed_volume(import_closed_mesh(folder / "out.obj")), 1.0 / 6.0, 1e-9);
  EXPECT_THROW(repair_file(in, folder / "out.stl"), Error);
}

}  // namespace
}  // namespace thew::tests
