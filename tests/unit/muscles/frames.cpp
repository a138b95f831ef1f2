// SPDX-License-Identifier: Apache-2.0
#include "muscles/frames.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "rig/math.h"

namespace thew::tests {
namespace {

constexpr int kPieces = 128;
constexpr double kLeg = 0.04, kRadius = 0.01;  // m

// A line that bends by 90 degrees about an arc between two legs; its length and point at a share.
double length_of_line() { return 2.0 * kLeg + 0.5 * kPi * kRadius; }
Vec3 point_at(double share) {
  const double s = share * length_of_line(), arc = 0.5 * kPi * kRadius;
  if (s < kLeg) return {s, 0, 0};
  if (s > kLeg + arc) return {kLeg + kRadius, -(kRadius + s - kLeg - arc), 0};
  const SinCos turn = sin_cos((s - kLeg) / kRadius);
  return {kLeg + kRadius * turn.sin, -kRadius + kRadius * turn.cos, 0};
}
std::vector<Vec3> line() {
  std::vector<Vec3> points;
  for (int i = 0; i <= kPieces; ++i) points.push_back(point_at(double(i) / kPieces));
  return points;
}

// A tube about it, its rings `inside` (m) towards the centre of the bend.
TriMesh tube_about(double radius, double inside, int around = 12, int rings = 31) {
  TriMesh mesh;
  const auto place = [&](double share) {
    const Vec3 t = (point_at(std::min(share + 1e-6, 1.0)) - point_at(std::max(share - 1e-6, 0.0)))
                       .normalized();
    const Vec3 in(t.y(), -t.x(), 0);
    return std::pair(Vec3(point_at(share) + inside * in), in);
  };
  mesh.vertices.push_back(place(0.0).first);
  for (int r = 0; r < rings; ++r) {
    const auto [at, in] = place((r + 0.5) / rings);
    for (int k = 0; k < around; ++k) {
      const SinCos turn = sin_cos(2.0 * kPi * k / around);
      mesh.vertices.push_back(at + radius * (turn.cos * in + turn.sin * Vec3::UnitZ()));
    }
  }
  mesh.vertices.push_back(place(1.0).first);
  const auto node = [&](int r, int k) { return 1 + r * around + k % around; };
  for (int r = 0; r + 1 < rings; ++r) {
    for (int k = 0; k < around; ++k) {
      mesh.triangles.push_back({node(r, k), node(r + 1, k), node(r, k + 1)});
      mesh.triangles.push_back({node(r, k + 1), node(r + 1, k), node(r + 1, k + 1)});
    }
  }
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({0, node(0, k), node(0, k + 1)});
    mesh.triangles.push_back(
        {node(rings - 1, k + 1), node(rings - 1, k), static_cast<int>(mesh.vertices.size()) - 1});
  }
  return mesh;
}

// The farthest that a ring's feet lie apart (m).
double spread(const TriMesh& mesh, const std::vector<double>& feet, int around = 12) {
  double most = 0.0;
  for (size_t i = 1; i + 1 < mesh.vertices.size(); i += around) {
    const auto [low, high] = std::minmax_element(feet.begin() + i, feet.begin() + i + around);
    most = std::max(most, (*high - *low) * length_of_line());
  }
  return most;
}

// Where nothing is in doubt the foot is the nearest point, to the last bit that a sum of lengths
// leaves.
TEST(FeetAlong, AreWhereTheLineIsNearest) {
  const TriMesh mesh = tube_about(0.002, 0.0);
  const std::vector<double> feet = feet_along(line(), mesh);
  EXPECT_LT(spread(mesh, feet), 2e-4);
  for (size_t i = 0; i < feet.size(); ++i) {
    const Vec3 way = mesh.vertices[i] - point_at(feet[i]);
    if (feet[i] <= 0.0 || feet[i] >= 1.0) continue;
    const Vec3 t = point_at(feet[i] + 1e-6) - point_at(feet[i] - 1e-6);
    EXPECT_LT(std::abs(way.dot(t.normalized())), 1e-4);
  }
}

// A thick ring in the bend reaches beyond the centre of the arc, from where one leg is as near as
// the other. By the nearest point its nodes' feet would lie a radius and more apart, and when the
// bend opens the ring would be torn along the muscle.
TEST(FeetAlong, OfARingInABendStayTogether) {
  const TriMesh mesh = tube_about(0.004, 0.0075, 12, 9);
  const std::vector<double> feet = feet_along(line(), mesh);
  EXPECT_LT(spread(mesh, feet), 3e-3);
  EXPECT_EQ(feet.front(), 0.0);
  EXPECT_EQ(feet.back(), 1.0);
}

}  // namespace
}  // namespace thew::tests
