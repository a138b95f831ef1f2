// SPDX-License-Identifier: Apache-2.0
#include "tools/render/draw_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/tools/render/ball.h"

namespace thew::tests {
namespace {

TEST(DrawGeometry, EdgePointsOfACoarseBallLieOnTheBall) {
  const std::vector<BakeMesh> meshes = {
      ball("ball", BakeMesh::Kind::kSkin, Vec3::Zero(), 1.0, 1.0, 12, 5)};
  DrawGeometry geometry = make_draw_geometry(meshes);
  place_vertices(geometry.meshes[0], meshes[0].rest.vertices, geometry);
  ASSERT_EQ(geometry.vertices.size(),
            meshes[0].rest.vertices.size() + geometry.meshes[0].edges.size());
  EXPECT_EQ(geometry.indices.size(), 12 * meshes[0].rest.triangles.size());
  double flat = 0.0, drawn = 0.0;  // worst distance from the ball
  for (std::size_t e = 0; e < geometry.meshes[0].edges.size(); ++e) {
    const auto [i, j] = geometry.meshes[0].edges[e];
    const Vec3 middle = 0.5 * (meshes[0].rest.vertices[i] + meshes[0].rest.vertices[j]);
    const float* p = geometry.vertices[meshes[0].rest.vertices.size() + e].position;
    flat = std::max(flat, std::abs(middle.norm() - 1.0));
    drawn = std::max(drawn, std::abs(Vec3(p[0], p[1], p[2]).norm() - 1.0));
  }
  EXPECT_GT(flat, 0.02);
  EXPECT_LT(drawn, 0.15 * flat);
}

// The edges of a ball of radius 1 are about L^2 / 8 flatter than it.
TEST(DrawGeometry, OnlyWhatIsTooFlatIsRefined) {
  const std::vector<BakeMesh> meshes = {
      ball("coarse", BakeMesh::Kind::kSkin, Vec3::Zero(), 1.0, 1.0, 12, 5),
      ball("fine", BakeMesh::Kind::kSkin, Vec3::Zero(), 1.0, 1.0, 48, 23)};
  DrawGeometry geometry = make_draw_geometry(meshes, 0.01);
  EXPECT_FALSE(geometry.meshes[0].edges.empty());
  EXPECT_TRUE(geometry.meshes[1].edges.empty());
  EXPECT_EQ(geometry.indices.size(),
            12 * meshes[0].rest.triangles.size() + 3 * meshes[1].rest.triangles.size());
  EXPECT_TRUE(geometry.closed[static_cast<int>(BakeMesh::Kind::kSkin)]);
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    place_vertices(geometry.meshes[m], meshes[m].rest.vertices, geometry);
  }
  for (const DrawVertex& vertex : geometry.vertices) {
    EXPECT_NEAR(position_of(vertex).norm(), 1.0, 0.01);
  }
}

TEST(DrawGeometry, WeightSegmentsAreAsLongAsTheWeights) {
  std::vector<BakeMesh> meshes = {ball("m", BakeMesh::Kind::kMuscle, Vec3::Zero(), 1.0)};
  for (std::size_t i = 0; i < meshes[0].weights.size(); ++i) meshes[0].weights[i] = 0.01 * i;
  DrawGeometry geometry = make_draw_geometry(meshes);
  place_vertices(geometry.meshes[0], meshes[0].rest.vertices, geometry);
  const std::vector<DrawVertex> quads = weight_quads(meshes, geometry, Vec3(9, 2, 3), 0.1, 1e-3);
  ASSERT_EQ(quads.size(), 6 * meshes[0].weights.size());
  const auto at = [&](std::size_t k) {
    return Vec3(Eigen::Map<const Eigen::Vector3f>(quads[k].position).cast<double>());
  };
  for (std::size_t i = 0; i < meshes[0].weights.size(); ++i) {
    const double belly = meshes[0].coordinates[i][2];  // a tendon has no use for its weight
    EXPECT_NEAR((at(6 * i + 2) - at(6 * i)).norm(), 0.1 * 0.01 * i * belly, 1e-5);
  }
}

TEST(DrawGeometry, AnOpenOrInsideOutMeshKeepsItsBackFaces) {
  BakeMesh whole = ball("whole", BakeMesh::Kind::kBone, Vec3::Zero(), 1.0);
  BakeMesh open = whole, turned = whole;
  open.rest.triangles.pop_back();
  for (Triangle& t : turned.rest.triangles) std::swap(t[1], t[2]);
  EXPECT_TRUE(make_draw_geometry({whole}).closed[1]);
  EXPECT_FALSE(make_draw_geometry({whole, open}).closed[1]);
  EXPECT_FALSE(make_draw_geometry({turned}).closed[1]);
}

}  // namespace
}  // namespace thew::tests
