// SPDX-License-Identifier: Apache-2.0
// Facts that hold for every closed surface, on real ones.
#include <gtest/gtest.h>

#include <filesystem>

#include "rig/import/mesh_import.h"
#include "rig/math.h"
#include "tests/unit/rig/shapes.h"

namespace thew::tests {
namespace {

std::vector<TriMesh> closed_surfaces() {
  std::vector<TriMesh> meshes{unit_cube(), weld(split_cylinder(17)).mesh};
  for (const char* name : {"humerus.stl", "ulna.stl", "radius.stl", "spot.obj"}) {
    const auto file = std::filesystem::path(THEW_SHARED_DATA) / name;
    if (std::filesystem::exists(file)) meshes.push_back(import_mesh(file).mesh);
  }
  return meshes;
}

TEST(ClosedSurface, VolumeSurvivesRigidMotionAndScalesByTheCube) {
  for (const TriMesh& mesh : closed_surfaces()) {
    const double volume = enclosed_volume(mesh);
    TriMesh moved = mesh, scaled = mesh;
    const Mat3 turn = rotation_about(Vec3(1, -2, 0.5).normalized(), 2.1);
    for (Vec3& p : moved.vertices) p = turn * p + Vec3(10.0, -20.0, 5.0);
    for (Vec3& p : scaled.vertices) p *= 2.0;
    EXPECT_NEAR(enclosed_volume(moved) / volume, 1.0, 1e-11);
    EXPECT_NEAR(enclosed_volume(scaled) / volume, 8.0, 1e-13);
  }
}

TEST(ClosedSurface, AreaVectorsSumToZero) {
  for (const TriMesh& mesh : closed_surfaces()) {
    Vec3 sum = Vec3::Zero();
    double area = 0.0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 a = mesh.vertices[t[0]];
      const Vec3 twice = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
      sum += twice;
      area += twice.norm();
    }
    EXPECT_LT(sum.norm() / area, 1e-12);
  }
}

TEST(ClosedSurface, WeldIsIdempotent) {
  for (const TriMesh& mesh : closed_surfaces()) {
    const WeldResult again = weld(mesh);
    EXPECT_EQ(again.mesh.vertices.size(), mesh.vertices.size());
    EXPECT_EQ(again.mesh.triangles, mesh.triangles);
  }
}

// Take any triangle away: three open edges and nothing else. Turn it: three of wrong winding.
TEST(ClosedSurface, EveryTriangleIsMissed) {
  for (const TriMesh& mesh : closed_surfaces()) {
    const size_t stride = mesh.triangles.size() / 12 + 1;
    for (size_t t = 0; t < mesh.triangles.size(); t += stride) {
      TriMesh holed = mesh, turned = mesh;
      holed.triangles.erase(holed.triangles.begin() + static_cast<long>(t));
      std::swap(turned.triangles[t][0], turned.triangles[t][1]);
      const auto open = find_defects(holed), wrong = find_defects(turned);
      ASSERT_EQ(open.size(), 1u);
      EXPECT_EQ(open[0].kind, Defect::kOpenEdge);
      EXPECT_EQ(open[0].count, 3);
      ASSERT_EQ(wrong.size(), 1u);
      EXPECT_EQ(wrong[0].kind, Defect::kInconsistentWinding);
      EXPECT_EQ(wrong[0].count, 3);
    }
  }
}

}  // namespace
}  // namespace thew::tests
