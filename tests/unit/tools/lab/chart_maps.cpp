// SPDX-License-Identifier: Apache-2.0
//
// Maps of failure: verdicts of a small scene, and what is drawn of them.
#include <gtest/gtest.h>

#include <algorithm>

#include "rig/types.h"
#include "tools/lab/chart/maps.h"

namespace thew::tests {
namespace {

TEST(StabilityMaps, OfLocalGlobalUnderTenDecadesOfStiffness) {
  MapAsk ask{.scene = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml",
             .threads = 2,
             .only_method = "local_global",
             .only_quantity = "stiffness"};
  int last = 0;
  ask.on_cell = [&](int done, int total) { last = total - done; };
  const std::vector<StabilityMap> maps = run_maps(ask);
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(last, 0);
  EXPECT_EQ(maps[0].columns.back() / maps[0].columns.front(), 1e10);
  EXPECT_EQ(maps[0].steps.back(), 0.2);
  for (const std::vector<MapCell>& row : maps[0].cells) {
    for (const MapCell& cell : row) {
      EXPECT_EQ(cell.verdict, Verdict::kAccurate) << cell.failure;
      EXPECT_LE(cell.volume_error, 1e-12);
    }
  }
  const std::string csv = maps_csv(maps);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 6 * 4);
  EXPECT_EQ(csv.find("nan"), std::string::npos);
}

TEST(StabilityMaps, ShowWhatFailedAndWhy) {
  StabilityMap map{"explicit", "stiffness", "times the scene's", {1, 100}, {0.1}, {{{}, {}}}};
  map.cells[0][0].verdict = Verdict::kAccurate;
  map.cells[0][1].verdict = Verdict::kDiverged;
  map.cells[0][1].failure = "muscle \"body\", node 3";
  const std::string svg = draw_map(map);
  EXPECT_NE(svg.find("✓"), std::string::npos);
  EXPECT_NE(svg.find("✕"), std::string::npos);
  EXPECT_NE(svg.find("diverged: muscle &quot;body&quot;, node 3"), std::string::npos);
  EXPECT_NE(maps_csv({map}).find("explicit,stiffness,100,0.1,diverged,,,,,,,\n"),
            std::string::npos);
  EXPECT_NE(maps_json({map}).find("node 3"), std::string::npos);
  EXPECT_NE(maps_html("a & b", {map}).find("a &amp; b"), std::string::npos);
}

}  // namespace
}  // namespace thew::tests
