// SPDX-License-Identifier: Apache-2.0
//
// Speed against accuracy: the front of known points, and a small scene's whole table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "sim/lone_frame.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "tests/unit/rig/temp.h"
#include "tools/lab/base/play.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/chart/skin_chart.h"

namespace thew::tests {
namespace {

ChartPoint point(double milliseconds, double largest, const std::string& failure = "") {
  ChartPoint out;
  out.setting = {"local_global", "exact", 1, 1};
  out.milliseconds = milliseconds;
  out.largest_mm = largest;
  out.failure = failure;
  return out;
}

TEST(ParetoFront, HasWhatNoCheaperOneBeats) {
  const std::vector<ChartPoint> points = {
      point(4, 0.5), point(1, 2),  point(2, 3), point(2, 1), point(0.1, 0, "diverged"),
      point(5, 0.5), point(8, 0.1)};
  EXPECT_EQ(pareto_front(points, &ChartPoint::largest_mm), (std::vector<std::size_t>{1, 3, 0, 6}));
}

TEST(ChartSettings, HaveTheScenesOwnOnce) {
  Scene scene;
  scene.solver.iterations = 7;
  const std::vector<ChartSetting> settings = chart_settings(scene);
  EXPECT_EQ(std::count(settings.begin(), settings.end(), settings.front()), 1);
  EXPECT_EQ(settings.front(), (ChartSetting{"local_global", "exact", 1, 7}));
  scene.solver.iterations = 3;
  EXPECT_EQ(chart_settings(scene).size(), settings.size() - 1);
}

TEST(ChartSettings, HaveZonesWhereTheSceneAsksForThem) {
  Scene scene;
  const auto zonal = [&] {
    const std::vector<ChartSetting> settings = chart_settings(scene);
    return std::count_if(settings.begin(), settings.end(),
                         [](const ChartSetting& setting) { return setting.volume == "zonal"; });
  };
  EXPECT_EQ(zonal(), 0);
  EXPECT_EQ(chart_refinements(8, "linear")[0].settings.back().volume, "exact");
  scene.solver.volume = "zonal";
  EXPECT_EQ(zonal(), 16);  // the grid of local_global, the scene's own in it, and quasi_static
  for (const ChartSetting& setting : chart_settings(scene)) {
    if (setting.volume != "zonal") continue;
    EXPECT_TRUE(setting.integrator == "local_global" || setting.integrator == "quasi_static");
  }
  const std::vector<Refinement> refinements = chart_refinements(8, "zonal");
  EXPECT_EQ(refinements[0].settings.back().volume, "zonal");
  EXPECT_EQ(refinements[1].settings.back().volume, "exact");  // xpbd knows no zones
}

TEST(Chart, SaysWhatFailed) {
  Chart chart;
  chart.points = {point(1, 2), point(0, 0, "node 3 of \"biceps\" is not finite")};
  chart.points[1].setting = {"explicit", "linear", 4, 1};
  const std::string svg = draw_cost(chart, &ChartPoint::largest_mm, "error");
  EXPECT_NE(svg.find("1 of 2 runs failed or given up"), std::string::npos);
  EXPECT_NE(svg.find("✕ explicit: 4 linear<"), std::string::npos);
  EXPECT_NE(svg.find("explicit: failed"), std::string::npos);  // it has no point
  chart.points.push_back(chart.points[1]);
  chart.points[2].setting.substeps = 16;
  EXPECT_NE(
      draw_cost(chart, &ChartPoint::largest_mm, "error").find("✕ explicit: 4 linear, 16 linear<"),
      std::string::npos);
  chart.points.pop_back();
  chart.points[1].failure = std::string(kGivenUp) + "its first frame takes about 7000 ms of CPU";
  EXPECT_NE(draw_cost(chart, &ChartPoint::largest_mm, "error").find("explicit: given up"),
            std::string::npos);
  chart.points[1].failure.clear();
  EXPECT_EQ(draw_cost(chart, &ChartPoint::largest_mm, "error").find("explicit: "),
            std::string::npos);
  chart.points[1].failure = "node 3 of \"biceps\" is not finite";
  EXPECT_NE(chart_csv(chart).find("explicit,linear,4,1,0,0,1,,,,,,,\n"), std::string::npos);
  EXPECT_NE(chart_html(chart).find("node 3 of &quot;biceps&quot;"), std::string::npos);
}

// From frame to frame a pinched muscle may swing for good, and no bake goes that way.
TEST(Played, SolvesWhatStandsAloneByItselfAsABakeDoes) {
  const Model model = solved_as(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml"),
                                {"quasi_static", "exact", 1, 1});
  const int last = model.first_frame + 3;
  const Played played = play(model, settled_state(model), last);
  Parallel one(1);
  StageSeconds stages;
  State state = initial_state(model);
  solve_lone_frame(model, 3 / model.fps, one, state, stages);
  const Points &a = played.state.muscles[0].x, &b = state.muscles[0].x;
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(norm(a[i] - b[i]), 0.0) << i;
}

// A sanitized build gives up what would take minutes; no other does, however slow the machine.
#ifdef THEW_SANITIZED
constexpr double kLongestRun = 3.0;
#else
constexpr double kLongestRun = 1e6;
#endif

TEST(Chart, OfOneMuscle) {
  ChartAsk ask{.scene = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml",
               .last = 6,
               .threads = 2,
               .repetitions = 1,
               .longest_run = kLongestRun};
  const Chart chart = run_chart(ask);
  ASSERT_EQ(chart.refinements.size(), 3u);
  for (const Refinement& refinement : chart.refinements) {  // of first order at least, to one limit
    if (kLongestRun < 1e6 && refinement.failure.starts_with("given up")) continue;
    EXPECT_EQ(refinement.failure, "");
    ASSERT_EQ(refinement.order.size() + 2, refinement.settings.size());
    EXPECT_GT(refinement.order.back(), 0.9) << refinement.integrator;
    EXPECT_LT(refinement.apart_mm, 0.002) << refinement.integrator;
  }
  EXPECT_EQ(chart.refinements[0].apart_mm, 0.0);

  const auto is_default = [](const ChartPoint& p) { return p.is_default; };
  ASSERT_EQ(std::count_if(chart.points.begin(), chart.points.end(), is_default), 1);
  const auto own = std::find_if(chart.points.begin(), chart.points.end(), is_default);
  EXPECT_EQ(own->setting, (ChartSetting{"local_global", "exact", 1, 3}));
  EXPECT_LT(own->volume_error, 1e-9);
  EXPECT_GT(own->milliseconds, 0.0);
  const auto loose = std::find_if(chart.points.begin(), chart.points.end(), [](const auto& p) {
    return p.setting == ChartSetting{"local_global", "none", 1, 3};
  });
  ASSERT_NE(loose, chart.points.end());
  EXPECT_GT(loose->volume_error, 1e-4);

  const std::string csv = chart_csv(chart);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'),
            static_cast<std::ptrdiff_t>(chart.points.size()) + 1);
  const std::string svg = draw_cost(chart, &ChartPoint::largest_mm, "error");
  EXPECT_NE(svg.find("class=\"default\""), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

// A muscle's contact with itself is known to two integrators alone: the others are not run without.
TEST(Chart, SaysWhatCannotSolveTheScenesContact) {
  const Chart chart = run_chart({.scene = THEW_SOURCE_DIR "/tests/scenes/horseshoe/scene.toml",
                                 .last = 3,
                                 .threads = 1,
                                 .repetitions = 1,
                                 .longest_run = kLongestRun});
  for (const ChartPoint& point : chart.points) {
    const std::string& integrator = point.setting.integrator;
    const bool knows = integrator == "local_global" || integrator == "quasi_static";
    EXPECT_EQ(point.failure.starts_with("cannot solve the scene's friction"), !knows) << integrator;
  }
  EXPECT_EQ(chart.refinements.size(), 3u);
  EXPECT_EQ(chart.refinements[0].failure, "");
  for (int k = 1; k < 3; ++k) EXPECT_NE(chart.refinements[k].failure, "");
}

class ChartPicture : public TempFolder {};

// A program of the test's own in the place of rsvg-convert, and none.
TEST_F(ChartPicture, IsDrawnWhereItCanBe) {
  const std::string path = std::getenv("PATH");
  const auto svg = write("chart.svg", "<svg/>"), png = folder / "chart.png";
  setenv("PATH", folder.c_str(), 1);
  EXPECT_EQ(write_picture(png, svg), "");
  EXPECT_FALSE(std::filesystem::exists(png));
  const auto program = [&](const std::string& script) {
    write("rsvg-convert", "#!/bin/sh\n" + script + "\n");
    std::filesystem::permissions(folder / "rsvg-convert", std::filesystem::perms::owner_all);
    setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
  };
  program("exit 3");
  EXPECT_NE(write_picture(png, svg).find("rsvg-convert ended with 3"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(png));
  program("cp \"$5\" \"$4\"");
  EXPECT_EQ(write_picture(png, svg), "");
  EXPECT_EQ(std::filesystem::file_size(png), 6u);
  setenv("PATH", path.c_str(), 1);
}

TEST(SkinSettings, VolumeOnlyOfALayer) {
  const SkinSetting own{6, 4, true};
  const std::vector<SkinSetting> layer = skin_settings(own, true);
  EXPECT_EQ(layer.front(), own);
  EXPECT_EQ(std::count(layer.begin(), layer.end(), own), 1);
  EXPECT_EQ(layer.back(), (SkinSetting{6, 4, false}));
  for (const SkinSetting& setting : skin_settings({6, 4, false}, false)) {
    EXPECT_FALSE(setting.keeps_volume);
  }
}

// What errors there are to find is the arm's to tell (property_sim_skin_arm).
TEST(SkinChart, HasAllSettingsOfASmallSkin) {
  const SkinChart skin = run_skin_chart({.scene = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
                                         .last = 12,
                                         .threads = 2,
                                         .repetitions = 1});
  EXPECT_GT(skin.known_mm, 0.0);
  EXPECT_GT(skin.chart.points.front().largest_mm, 0.0);
  for (std::size_t k = 0; k < skin.settings.size(); ++k) {
    const ChartPoint& point = skin.chart.points[k];
    EXPECT_EQ(point.failure, "") << skin_setting_name(skin.settings[k]);
    EXPECT_EQ(point.is_default, k == 0);
    EXPECT_GT(point.milliseconds, 0.0);
    EXPECT_GE(skin.flip[k], 0.0);
    if (skin.settings[k].keeps_volume) {
      EXPECT_LT(point.volume_error, 1e-12);
    }
  }
  const Table table = points_of(skin);
  EXPECT_EQ(table.rows.size(), skin.settings.size());
  const std::string page = html_of(skin);
  EXPECT_NE(page.find("class=\"default\""), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(SkinChart, OfMusclesAloneIsNone) {
  const SkinChart skin =
      run_skin_chart({.scene = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml"});
  EXPECT_TRUE(skin.settings.empty());
  EXPECT_EQ(html_of(skin), "");
}

}  // namespace
}  // namespace thew::tests
