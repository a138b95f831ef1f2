// SPDX-License-Identifier: Apache-2.0
#include "muscles/zone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

std::vector<double> distances(const TriMesh& mesh, const std::vector<int>& sources) {
  ZoneWork work;
  std::vector<double> distance;
  surface_distance(surface_links(mesh), mesh.vertices, sources, work, distance);
  return distance;
}

std::vector<double> weights_around(const TriMesh& mesh, const std::vector<int>& loaded,
                                   const Vec3& direction, const ZoneSettings& settings,
                                   double radius) {
  ZoneWork work;
  work.loaded = loaded;
  std::vector<double> weights;
  zone_weights(surface_links(mesh), mesh.vertices, direction, settings, radius, work, weights);
  return weights;
}

TEST(Zone, WeightIsOneAtTheLoadAndZeroFromTheRadiusOn) {
  EXPECT_DOUBLE_EQ(zone_weight(0.0, 0.1), 1.0);
  EXPECT_NEAR(zone_weight(0.05, 0.1), 0.5, 1e-15);
  EXPECT_EQ(zone_weight(0.1, 0.1), 0.0);
  EXPECT_LT(zone_weight(0.1 - 1e-9, 0.1), 1e-15);  // no step at the rim, unlike the print's 0.77
  EXPECT_EQ(zone_weight(INFINITY, 0.1), 0.0);
  EXPECT_EQ(zone_weight(0.0, 0.0), 1.0);
}

TEST(Zone, DistanceOnASheetIsNearlyStraight) {
  const TriMesh mesh = sheet(12, 12, 1.0);
  const std::vector<double> d = distances(mesh, {0});
  for (size_t i = 0; i < d.size(); ++i) {
    const double straight = mesh.vertices[i].norm();
    EXPECT_GE(d[i], straight - 1e-12);
    EXPECT_LE(d[i], 1.09 * straight + 1e-12);
  }
  EXPECT_DOUBLE_EQ(d[12], 12.0);
  EXPECT_NEAR(d[13 * 2 + 1], std::sqrt(5.0), 1e-15);  // across an edge, not along two
}

TEST(Zone, UnreachedIsInfinite) {
  TriMesh mesh = sheet(1, 1, 1.0);
  mesh.vertices.emplace_back(0.5, 0.5, 0.0);
  EXPECT_TRUE(std::isinf(distances(mesh, {0}).back()));
}

TEST(Zone, DoesNotLeakAcrossAFold) {
  // A sheet folded back on itself: the far ends are 1 mm apart in space, 0.2 m along the surface.
  TriMesh mesh = sheet(20, 4, 0.01);
  for (Vec3& p : mesh.vertices) {
    if (p.x() > 0.105) p = {0.2 - p.x(), p.y(), 0.001};
  }
  EXPECT_LT((mesh.vertices[0] - mesh.vertices[100]).norm(), 0.0011);
  EXPECT_NEAR(distances(mesh, {0})[100], 0.2, 0.011);
  const std::vector<double> w = weights_around(mesh, {0}, Vec3::Zero(), {}, 0.05);
  EXPECT_GT(w[5 * 2], 0.0);  // two columns away
  EXPECT_EQ(w[100], 0.0);
  EXPECT_EQ(w[5 * 18], 0.0);
}

TEST(Zone, WeightsSumToTheNumberOfNodesAndFallWithDistance) {
  const TriMesh mesh = spindle();
  const std::vector<double> w = weights_around(mesh, {100, 101}, Vec3::Zero(), {}, 0.06);
  EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), w.size(), 1e-10);
  const std::vector<double> d = distances(mesh, {100, 101});
  for (size_t i = 0; i < w.size(); ++i) {
    EXPECT_NEAR(w[i] / w[100], zone_weight(d[i], 0.06), 1e-14);
  }
}

TEST(Zone, StretchesAlongTheLoad) {
  const TriMesh mesh = sheet(20, 20, 0.01);
  ZoneSettings settings;
  settings.along_load = 0.5;
  const int middle = 10 * 21 + 10;
  const std::vector<double> w = weights_around(mesh, {middle}, Vec3::UnitX(), settings, 0.045);
  EXPECT_GT(w[(10 + 8) * 21 + 10], 0.0);  // 80 mm along the load count as 40
  EXPECT_EQ(w[10 * 21 + 10 + 5], 0.0);    // 50 mm across count as they are
  EXPECT_NEAR(w[(10 + 8) * 21 + 10], w[10 * 21 + 10 + 4], 1e-12);
}

TEST(Zone, RadiusGrowsWithAmountAndDurationUpToTheThreshold) {
  ZoneSettings settings{.smallest_radius = 0.01, .largest_radius = 0.05, .per_impulse = 0.002};
  EXPECT_DOUBLE_EQ(grown_radius(settings, 0.0, 0.0, 0.1), 0.01);
  double slow = 0.01, fast = 0.01;
  for (int i = 0; i < 10; ++i) slow = grown_radius(settings, slow, 5.0, 0.1);
  for (int i = 0; i < 5; ++i) fast = grown_radius(settings, fast, 10.0, 0.1);
  EXPECT_NEAR(slow, 0.02, 1e-15);
  EXPECT_NEAR(fast, 0.02, 1e-15);
  EXPECT_DOUBLE_EQ(grown_radius(settings, 0.04, 1000.0, 1.0), 0.05);
}

}  // namespace
}  // namespace thew::tests
