// SPDX-License-Identifier: Apache-2.0
#include "muscles/activation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rig/types.h"

namespace thew::tests {
namespace {

TEST(Activation, LandmarksOfTheCurves) {
  EXPECT_DOUBLE_EQ(active_force_length(1.0), 1.0);
  EXPECT_LT(active_force_length(0.3), 0.35);
  EXPECT_DOUBLE_EQ(active_force_length(0.7), active_force_length(1.3));
  EXPECT_EQ(passive_force_length(0.8), 0.0);
  EXPECT_EQ(passive_force_length(1.0), 0.0);
  EXPECT_DOUBLE_EQ(passive_force_length(1.6), 1.0);
  EXPECT_DOUBLE_EQ(force_velocity(0.0), 1.0);
  EXPECT_EQ(force_velocity(-10.0), 0.0);
  EXPECT_EQ(force_velocity(-20.0), 0.0);
  EXPECT_NEAR(force_velocity(1e9), 1.4, 1e-6);
  EXPECT_NEAR(force_velocity(1e-9), force_velocity(-1e-9), 1e-8);
}

// Thelen 2003 eq. 6 gives the velocity of a force; ours is its inverse.
TEST(Activation, ForceVelocityInvertsThelen) {
  for (double force : {0.1, 0.5, 0.9, 1.05, 1.2, 1.35}) {
    const double b =
        force <= 1.0 ? 1.0 + force / 0.25 : (2.0 + 2.0 / 0.25) * (1.4 - force) / (1.4 - 1.0);
    EXPECT_NEAR(force_velocity(10.0 * (force - 1.0) / b), force, 1e-14);
  }
}

TEST(Activation, CurvesAreThoseOfTheStandardLibrary) {
  for (double l = 0.2; l < 2.0; l += 0.01) {
    const double active = std::exp(-(l - 1) * (l - 1) / 0.45);
    EXPECT_NEAR(active_force_length(l), active, 4e-16 * active);
    const double passive = (std::exp(5 * (l - 1) / 0.6) - 1) / (std::exp(5.0) - 1);
    EXPECT_NEAR(passive_force_length(l), l > 1 ? passive : 0.0, 1e-14 * (1 + std::fabs(passive)));
  }
  EXPECT_EQ(active_force_length(100.0), 0.0);
  EXPECT_TRUE(std::isnan(active_force_length(NAN)));
}

TEST(Activation, TensionAddsUp) {
  EXPECT_DOUBLE_EQ(muscle_tension(600.0, 1.0, 1.0, 0.0), 600.0);
  EXPECT_NEAR(muscle_tension(600.0, 0.0, 1.6, 5.0), 600.0, 1e-11);
  EXPECT_DOUBLE_EQ(muscle_tension(600.0, 0.5, 1.0, -10.0), 0.0);
}

}  // namespace
}  // namespace thew::tests
