// SPDX-License-Identifier: Apache-2.0
//
// Zones compared with finite elements of the same bar between the same plates.
#include <gtest/gtest.h>

#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/peers/bar_chart.h"

namespace thew::tests {
namespace {

const std::string kScene = THEW_SOURCE_DIR "/assets/paper/bar.toml";

TEST(Bar, ZonesAreNearerToFiniteElementsWhereTwoBelliesMeet) {
  const TrueBar truth = squeeze_true_bar({.neck = kNeck}, 2);
  ASSERT_TRUE(truth.result.converged);
  EXPECT_EQ(truth.result.inverted, 0);
  EXPECT_NEAR(fem_volume(truth.squeezed) / fem_volume(truth.rest), 1.0, 1e-3);
  EXPECT_LE(truth.result.penetration, 1e-4);
  const TriMesh rest = octant_surface(truth.rest), now = octant_surface(truth.squeezed);
  const double grown = free_half(rest, now.vertices) / free_half(rest, rest.vertices) - 1.0;
  EXPECT_LT(std::abs(grown), 0.02);  // volume does not run along the bar
  const std::vector<BarRun> runs =
      run_bars(kScene, {{"solver.volume=exact"}, {"muscle.bar.zones=2"}, {}}, 0, truth);
  const BarRun& exact = runs[0];
  EXPECT_GT(exact.free_half, 0.15);
  for (const BarRun& zonal : {runs[1], runs[2]}) {
    EXPECT_LE(zonal.volume_error, 1e-14);
    EXPECT_LE(zonal.zone_error, 1e-11);
    EXPECT_EQ(zonal.zone_fallbacks, 0);
    EXPECT_LT(std::abs(zonal.free_half - grown), 0.02);
    EXPECT_LT(zonal.mean, 0.4 * exact.mean);
    EXPECT_LT(zonal.largest, 0.6 * exact.largest);
    EXPECT_LT(zonal.mean, 1.1e-3);  // m, of a half thickness of 50 mm
  }
}

}  // namespace
}  // namespace thew::tests
