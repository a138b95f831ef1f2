// SPDX-License-Identifier: Apache-2.0
#include "tools/base/bake_mesh.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/unit/rig/shapes.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tests {
namespace {

// With vertices of its own for each triangle, as files that are shaded flat have it.
BakeMesh in_triangles(const TriMesh& mesh) {
  BakeMesh out;
  out.kind = BakeMesh::Kind::kSkin;
  for (const Triangle& t : mesh.triangles) {
    const int first = static_cast<int>(out.rest.vertices.size());
    for (const int i : t) out.rest.vertices.push_back(mesh.vertices[i]);
    out.rest.triangles.push_back({first, first + 1, first + 2});
  }
  return out;
}

size_t shades_of(const BakeMesh& mesh) {
  const std::vector<int> shaded = shaded_vertices(mesh);
  return std::set<int>(shaded.begin(), shaded.end()).size();
}

TEST(ShadedVertices, OfASkinAreApartWhereItsEdgeIsSharp) {
  const TriMesh ball = ringed_ball(12, 16);
  ASSERT_EQ(shades_of(in_triangles(ball)), ball.vertices.size());  // it was drawn in facets
  const BakeMesh cube = in_triangles(unit_cube());
  EXPECT_EQ(shades_of(cube), 24u);  // four corners of six sides
  for (const Triangle& t : shaded_triangles(cube)) {
    const auto& x = cube.rest.vertices;
    const Vec3 normal = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).normalized();
    EXPECT_NEAR(normal.cwiseAbs().maxCoeff(), 1.0, 1e-12);
  }
}

TEST(ShadedVertices, OfFleshAndBoneAreSmoothAlongEverySeam) {
  BakeMesh bone = in_triangles(unit_cube());
  bone.kind = BakeMesh::Kind::kBone;
  EXPECT_EQ(shades_of(bone), 8u);
}

}  // namespace
}  // namespace thew::tests
