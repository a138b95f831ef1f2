// SPDX-License-Identifier: Apache-2.0
#include "muscles/weights.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <stdexcept>

#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

TEST(Weights, ProfilesAreLinearBetweenKeysAndConstantBeyond) {
  const WeightProfile left = preset_profile("left");
  EXPECT_DOUBLE_EQ(profile_weight(left, 0.0), 1.8);
  EXPECT_DOUBLE_EQ(profile_weight(left, 0.5), 1.0);
  EXPECT_DOUBLE_EQ(profile_weight(left, 1.0), 0.2);
  EXPECT_DOUBLE_EQ(profile_weight(left, -1.0), 1.8);
  EXPECT_DOUBLE_EQ(profile_weight(left, 2.0), 0.2);
  EXPECT_DOUBLE_EQ(profile_weight(preset_profile("even"), 0.3), 1.0);
  EXPECT_DOUBLE_EQ(profile_weight(preset_profile("right"), 0.25), profile_weight(left, 0.75));
  EXPECT_THROW(preset_profile("middle"), std::invalid_argument);
  const WeightProfile step{{{0.2, 1.0}, {0.4, 3.0}, {0.4, 0.0}, {1.0, 0.0}}};
  EXPECT_DOUBLE_EQ(profile_weight(step, 0.4), 3.0);
  EXPECT_DOUBLE_EQ(profile_weight(step, 0.5), 0.0);
}

TEST(Weights, SumIsTheNumberOfNodesAndDrivenOnesHaveNone) {
  const std::vector<double> w = normalised_weights({1, 2, 3, 4}, {0, 0, 1, 0});
  EXPECT_DOUBLE_EQ(std::accumulate(w.begin(), w.end(), 0.0), 4.0);
  EXPECT_EQ(w[2], 0.0);
  EXPECT_DOUBLE_EQ(w[3] / w[0], 4.0);
}

TEST(Weights, RefusesWhatCannotBeScaled) {
  EXPECT_THROW(normalised_weights({1, -1}, {0, 0}), std::invalid_argument);
  EXPECT_THROW(normalised_weights({1, NAN}, {0, 0}), std::invalid_argument);
  EXPECT_THROW(normalised_weights({1, INFINITY}, {0, 0}), std::invalid_argument);
  EXPECT_THROW(normalised_weights({0, 5}, {0, 1}), std::invalid_argument);
}

// Largest share of the correction, relative to the share under even weights.
double concentration(const std::vector<double>& w, const std::vector<double>& g) {
  double weighted = 0.0, even = 0.0;
  for (size_t i = 0; i < w.size(); ++i) {
    weighted += w[i] * g[i];
    even += g[i];
  }
  double largest = 0.0;
  for (size_t i = 0; i < w.size(); ++i) largest = std::max(largest, w[i] / weighted * even);
  return largest;
}

TEST(Weights, FiveHeavyNodesAreTamedByTheSmallestFloorThatDoes) {
  const size_t n = 500;
  std::vector<double> g(n), w(n, 0.0);
  for (size_t i = 0; i < n; ++i) g[i] = 1.0 + 0.5 * (i % 7);
  for (int i = 0; i < 5; ++i) w[40 + i] = 1.0;
  const std::vector<char> driven(n, 0);
  const std::vector<double> raw = w;
  EXPECT_GT(concentration(w, g), 80.0);
  const double floor = limit_concentration(w, g, driven);
  EXPECT_GT(floor, 0.0);
  EXPECT_NEAR(concentration(w, g), 1.5, 1e-12);
  EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.0), n, 1e-10);
  EXPECT_GT(w[42], w[0]);         // still the heavier ones
  std::vector<double> less(raw);  // any smaller floor is too small
  for (double& x : less) x += 0.999 * floor;
  EXPECT_GT(concentration(less, g), 1.5);
}

TEST(Weights, TameOnesStayAsTheyAre) {
  std::vector<double> w{0.8, 1.0, 1.2, 1.0};
  const std::vector<double> before = w;
  EXPECT_EQ(limit_concentration(w, {1, 1, 1, 1}, {0, 0, 0, 0}), 0.0);
  EXPECT_EQ(w, before);
  EXPECT_THROW(limit_concentration(w, {1, 1, 1, 1}, {0, 0, 0, 0}, 1.0), std::invalid_argument);
  // A driven node, or one without a gradient of the volume, sets no limit.
  w = {100.0, 100.0, 1.0, 1.0};
  EXPECT_EQ(limit_concentration(w, {1, 0, 1, 1}, {1, 0, 0, 0}), 0.0);
}

TEST(Weights, NetMotionIsTakenOut) {
  const Points x = to_points(spindle().vertices);
  const size_t n = x.size();
  std::vector<double> mass(n);
  for (size_t i = 0; i < n; ++i) mass[i] = 1.0 + 0.1 * (i % 5);
  Points d = noise(n, 1.0, 6);
  for (Point& row : d) row += Point{0.5, -0.2, 0.9, 0.0};
  const auto net = [&](Vec3& force, Vec3& torque) {
    force = torque = Vec3::Zero();
    for (size_t i = 0; i < n; ++i) {
      force += mass[i] * to_vec(d[i]);
      torque += mass[i] * to_vec(x[i]).cross(to_vec(d[i]));
    }
  };
  Vec3 force, torque;
  net(force, torque);
  const double force_before = force.norm(), torque_before = torque.norm();
  remove_net_motion(x, mass, d);
  net(force, torque);
  EXPECT_LT(force.norm(), 1e-15 * force_before);
  EXPECT_LT(torque.norm(), 1e-14 * torque_before);
  // A rigid motion is removed completely, and a field without net motion is unchanged.
  const Points still(d);
  remove_net_motion(x, mass, d);
  for (size_t i = 0; i < n; ++i) EXPECT_LT(to_vec(d[i] - still[i]).norm(), 1e-14);
  for (size_t i = 0; i < n; ++i)
    d[i] = to_point(Vec3(1, 2, 3) + Vec3(4, 5, -6).cross(to_vec(x[i])));
  remove_net_motion(x, mass, d);
  for (const Point& row : d) EXPECT_LT(to_vec(row).norm(), 1e-14);
}

TEST(Weights, NetMotionOfALineAndAPointIsFinite) {
  Points x{Point{0, 0, 0, 0}, Point{1, 0, 0, 0}, Point{2, 0, 0, 0}}, d = noise(3, 1.0, 7);
  remove_net_motion(x, {1, 1, 1}, d);
  for (const Point& row : d) EXPECT_TRUE(to_vec(row).allFinite());
  x.assign(3, Point{});
  remove_net_motion(x, {1, 1, 1}, d);
  for (const Point& row : d) EXPECT_TRUE(to_vec(row).allFinite());
}

}  // namespace
}  // namespace thew::tests
