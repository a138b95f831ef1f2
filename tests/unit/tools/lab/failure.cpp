// SPDX-License-Identifier: Apache-2.0
//
// Maps of failure: what is left out is what a run would have said; verdicts of a small scene, and
// what is drawn of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rig/types.h"
#include "tools/lab/failure/grid.h"
#include "tools/lab/failure/loads.h"
#include "tools/lab/failure/maps.h"

namespace thew::tests {
namespace {

constexpr const char* kScene = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml";

// Regions of two cells and more across, whose edge no row or column follows.
TEST(FilledGrid, LeavesOutOnlyWhatARunWouldHaveSaid) {
  const auto truth = [](int r, int c) {
    const bool island = std::hypot(r - 9, c - 14) < 2.5;
    return island ? 2 : r + 0.7 * c > 8 ? 1 : 0;
  };
  int runs = 0;
  const GridFill fill = fill_grid({.rows = 14, .columns = 19, .run = [&](int r, int c) {
                                     ++runs;
                                     return truth(r, c);
                                   }});
  int left_out = 0;
  for (int r = 0; r < 14; ++r) {
    for (int c = 0; c < 19; ++c) {
      EXPECT_EQ(fill.found[r][c], truth(r, c)) << r << ", " << c;
      left_out += fill.inferred[r][c];
    }
  }
  EXPECT_EQ(runs + left_out, 14 * 19);  // none twice
  EXPECT_GT(left_out, 14 * 19 / 4);
  EXPECT_GT(fill.checked, 0);
  EXPECT_EQ(fill.differed, 0);
}

// A tongue between two coarse rows, which no corner of a block shows beyond its root.
TEST(FilledGrid, FollowsABoundaryWhereItWasFound) {
  const auto truth = [](int r, int c) { return c < 4 || (r == 5 && c < 13) ? 1 : 0; };
  const GridFill fill =
      fill_grid({.rows = 11, .columns = 17, .run = truth, .check_every = 0, .all = false});
  for (int r = 0; r < 11; ++r) {
    for (int c = 0; c < 17; ++c) EXPECT_EQ(fill.found[r][c], truth(r, c)) << r << ", " << c;
  }
}

// What is smaller than a block is missed, unless a check meets it; that is told, and followed.
TEST(FilledGrid, TellsWhatACheckFoundOtherwise) {
  const auto truth = [](int r, int c) { return r % 2 == 1 && c % 2 == 1 ? 1 : 0; };
  const GridAsk ask{.rows = 5, .columns = 9, .run = truth, .check_every = 1};
  const GridFill fill = fill_grid(ask);
  EXPECT_GT(fill.differed, 0);
  for (int r = 0; r < 5; ++r) {
    for (int c = 0; c < 9; ++c) EXPECT_EQ(fill.found[r][c], truth(r, c));
  }
}

struct Small {
  const char *method, *quantity;
};
class SmallMaps : public ::testing::TestWithParam<Small> {};

TEST_P(SmallMaps, InferredCellsAreWhatTheirRunsSay) {
  MapAsk ask{.scene = kScene,
             .threads = 2,
             .only_method = GetParam().method,
             .only_quantity = GetParam().quantity};
  const std::vector<StabilityMap> some = run_maps(ask);
  ask.every_cell = true;
  const std::vector<StabilityMap> all = run_maps(ask);
  ASSERT_EQ(some.size(), all.size());
  int inferred = 0, otherwise = 0, run = 0;
  for (size_t m = 0; m < all.size(); ++m) {
    for (size_t s = 0; s < all[m].steps.size(); ++s) {
      for (size_t c = 0; c < all[m].columns.size(); ++c) {
        const MapCell &told = some[m].cells[s][c], &found = all[m].cells[s][c];
        inferred += told.inferred;
        run += !told.inferred;
        const bool same = told.verdict == found.verdict && told.mechanism == found.mechanism;
        EXPECT_TRUE(same || told.inferred);
        if (same) continue;
        ++otherwise;
        ADD_FAILURE() << all[m].quantity << " " << all[m].columns[c] << " at " << all[m].steps[s]
                      << ": told " << verdict_name(told.verdict) << ", run "
                      << verdict_name(found.verdict) << ", " << found.failure;
      }
    }
  }
  EXPECT_GE(inferred, 10) << run << " run";
  EXPECT_EQ(otherwise, 0);
}

INSTANTIATE_TEST_SUITE_P(Of, SmallMaps,
                         ::testing::Values(Small{"local_global", "stiffness"},
                                           Small{"local_global", ""}, Small{"Zordan 2004", ""}),
                         [](const auto& of) { return "Method" + std::to_string(of.index); });

TEST(StabilityMaps, OfLocalGlobalUnderTenDecadesOfStiffness) {
  MapAsk ask{
      .scene = kScene, .threads = 2, .only_method = "local_global", .only_quantity = "stiffness"};
  int last = -1;
  ask.on_map = [&](int done, int total) { last = total - done; };
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
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 11 * 5);
  EXPECT_EQ(csv.find("nan"), std::string::npos);
  EXPECT_TRUE(regions_of(maps).rows.empty());
}

// Shortened edges: closed, nothing turned over, the shortest edge as short as asked.
TEST(StabilityMaps, ShortenedEdgesKeepTheSurface) {
  const MapBody body = map_body(THEW_SOURCE_DIR "/assets/paper/ball.toml");
  ASSERT_FALSE(body.solid.vertices.empty());
  const MapBody thin = loaded_body(body, Load::kEdges, 1.0);
  int moved = 0;
  double shortest = 1.0;
  for (size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    moved += body.mesh.vertices[i] != thin.mesh.vertices[i];
  }
  for (const Triangle& t : body.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto length = [&](const MapBody& of) {
        return (of.mesh.vertices[t[k]] - of.mesh.vertices[t[(k + 1) % 3]]).norm();
      };
      shortest = std::min(shortest, length(thin) / length(body));
    }
  }
  EXPECT_NEAR(shortest, 0.01, 1e-9);
  EXPECT_GT(moved, static_cast<int>(body.mesh.vertices.size()) / 20);
  for (const Tetrahedron& t : thin.solid.tetrahedra) EXPECT_GT(signed_volume(thin.solid, t), 0.0);
  EXPECT_EQ(boundary(thin.solid), boundary(body.solid));
}

TEST(StabilityMaps, ShowWhatFailedAndWhy) {
  StabilityMap map;
  map.method = "explicit";
  map.quantity = "stiffness";
  map.unit = "times the scene's";
  map.columns = {1, 100, 500};
  map.steps = {0.1};
  map.cells = {{{}, {}, {}}};
  map.cells[0][0].verdict = Verdict::kAccurate;
  for (int c : {1, 2}) {
    map.cells[0][c].verdict = Verdict::kDiverged;
    map.cells[0][c].mechanism = Mechanism::kFliesOff;
  }
  map.cells[0][1].failure = "muscle \"body\", node 3";
  map.cells[0][2].inferred = true;
  map.with_rungs = {{Mechanism::kFliesOff, "a bake goes on"}};
  const std::string svg = draw_map(map);
  EXPECT_NE(svg.find("✓"), std::string::npos);
  EXPECT_NE(svg.find("diverged, flies off: muscle &quot;body&quot;, node 3"), std::string::npos);
  EXPECT_NE(svg.find("diverged, flies off: not run"), std::string::npos);
  EXPECT_NE(maps_csv({map}).find("explicit,stiffness,100,0.1,diverged,flies off,yes,,,,,,,\n"),
            std::string::npos);
  EXPECT_NE(maps_csv({map}).find("explicit,stiffness,500,0.1,diverged,flies off,no,,,,,,,\n"),
            std::string::npos);
  StabilityMap comma = map;
  comma.method = "Hong 2006, mended";
  EXPECT_NE(maps_csv({comma}).find("\n\"Hong 2006, mended\",stiffness,100,"), std::string::npos);
  EXPECT_NE(maps_json({map}).find("node 3"), std::string::npos);
  EXPECT_NE(maps_html("a & b", {map}, 1.0).find("a &amp; b"), std::string::npos);
  const Table regions = regions_of({map});
  ASSERT_EQ(regions.rows.size(), 1u);
  EXPECT_EQ(regions.rows[0].back(), "a bake goes on");
  EXPECT_EQ(verdicts_of({map}).rows[0][3], "2");  // cells that were run
  for (int k = 1; k <= static_cast<int>(Mechanism::kVolumeSoft); ++k) {
    const MechanismText& text = mechanism_text(static_cast<Mechanism>(k));
    EXPECT_TRUE(*text.name && *text.why && *text.thew) << k;
  }
}

}  // namespace
}  // namespace thew::tests
