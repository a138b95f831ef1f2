// SPDX-License-Identifier: Apache-2.0
#include "tools/report/report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "rig/types.h"
#include "tools/base/svg_chart.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Report sample() {
  Report report;
  report.scene = "arm <& co>";
  report.hash = "00112233445566778899aabbccddeeff";
  report.solver = {"local_global", "exact", 1, "it is the fastest within the bounds"};
  for (int frame = 1; frame <= 120; ++frame) report.frames.push_back(frame);
  for (int i = 0; i < 12; ++i) {
    Report::Muscle muscle;
    muscle.name = "muscle_" + std::to_string(i);
    muscle.vertices = 342;
    muscle.triangles = 680;
    muscle.rest_volume_m3 = 1.2e-4 + 1e-6 / 3;
    muscle.max_volume_error = 3e-15;
    muscle.max_volume_error_written = 4.5e-7;
    muscle.max_attachment_gap_m = 1e-9;
    for (int frame = 0; frame < 120; ++frame) {
      const double bend = 1.0 - std::abs(frame - 60) / 60.0;
      muscle.length_m.push_back(0.05 + 0.03 * i * (1.0 - 0.15 * bend));
      muscle.belly_area_ratio.push_back(1.0 + 0.04 * i * bend);
      muscle.volume_error_written.push_back(frame % 7 == 0 ? 0.0 : 1e-8 * (1 + i + frame % 5));
    }
    report.muscles.push_back(muscle);
  }
  report.skin = {9984, 1.5e-4, 2e-4, std::vector<double>(120, 1e-4), std::vector<double>(120, 2e-4),
                 3e-3, 2e-15,  3e-9};
  report.contact = {2e-4, std::vector<int>(120, 0)};
  report.seconds = {.total = {10.0, 15},
                    .setup = {0.1, 0.15},
                    .settle = {0.3, 0.45},
                    .measure = {0.5, 0.75},
                    .report = {0.2, 0.3},
                    .rig = {0.1, 0.15},
                    .muscles = {4.9, 7.35},
                    .contact = {1.5, 2.25},
                    .skin = {1.0, 1.5},
                    .write = {0.9, 1.35},
                    .render = {0.5, 0.75}};
  report.origin = {"/scenes/arm <1>.toml",
                   "5678",
                   "thew bake 'arm <1>.toml' --out out",
                   "9abc",
                   "2026-01-02T03:04:05Z",
                   "host",
                   "llvmpipe"};
  report.swings = {{"muscle_7", {40, 41, 50}, {1e-4, 2.5e-4, 1e-5}}};
  report.bounds = {{"volume_error", 4.5e-7, 1e-6}, {"penetration", 1.5e-4, 5e-4}};
  report.warnings = {"joint \"elbow\": clamped"};
  return report;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t times = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += word.size()) {
    ++times;
  }
  return times;
}

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

TEST(ReportJson, HasWhatIsPromised) {
  const Report report = sample();
  const json read = json::parse(report_as_json(report));
  using Words = std::vector<std::string>;
  EXPECT_EQ(keys(read), Words({"bounds", "contact", "cpu_seconds", "fps", "frames", "hash",
                               "muscles", "origin", "rungs", "scene", "seconds", "skin", "solver",
                               "swings", "thew", "threads", "warnings", "worst"}));
  EXPECT_EQ(keys(read["muscles"][3]),
            Words({"belly_area_ratio", "length_m", "max_attachment_gap_m",
                   "max_substep_volume_error", "max_volume_error", "max_volume_error_written",
                   "name", "rest_volume_m3", "triangles", "vertices"}));
  EXPECT_EQ(keys(read["seconds"]), Words({"contact", "measure", "muscles", "render", "report",
                                          "rig", "settle", "setup", "skin", "total", "write"}));
  EXPECT_EQ(keys(read["cpu_seconds"]), keys(read["seconds"]));
  EXPECT_EQ(read["seconds"]["skin"], 1.0);
  EXPECT_EQ(read["cpu_seconds"]["skin"], 1.5);
  EXPECT_EQ(keys(read["origin"]), Words({"command", "commit", "date", "directory", "host",
                                         "renderer", "scene", "scene_hash"}));
  EXPECT_EQ(keys(read["solver"]), Words({"chosen_because", "integrator", "substeps", "volume"}));
  EXPECT_EQ(keys(read["skin"]),
            Words({"max_covered_penetration_m", "max_penetration_m", "max_poke_through_m",
                   "max_volume_error", "max_volume_error_written", "triangles"}));
  EXPECT_EQ(keys(read["contact"]), Words({"intersecting_triangle_pairs", "max_penetration_m"}));
  EXPECT_EQ(read["scene"], report.scene);
  EXPECT_EQ(read["frames"], report.frames);
  EXPECT_EQ(read["seconds"]["write"], 0.9);
  EXPECT_EQ(read["muscles"][3]["max_volume_error"], 3e-15);
  EXPECT_EQ(read["muscles"][3]["max_volume_error_written"], 4.5e-7);
  EXPECT_EQ(read["origin"]["command"], report.origin.command);
  // Every digit comes back.
  EXPECT_EQ(read["muscles"][5]["rest_volume_m3"].get<double>(), report.muscles[5].rest_volume_m3);
  EXPECT_EQ(read["muscles"][5]["length_m"].get<std::vector<double>>(), report.muscles[5].length_m);
  EXPECT_EQ(read["bounds"][1]["met"], true);
  EXPECT_EQ(read["swings"][0]["frames"], json({40, 41, 50}));
  EXPECT_EQ(read["swings"][0]["max_swing_m"], 2.5e-4);
}

TEST(ReportJson, NeverHoldsWhatIsNotANumber) {
  Report report = sample();
  report.muscles[2].length_m[7] = std::numeric_limits<double>::quiet_NaN();
  try {
    report_as_json(report);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kOutput);
    EXPECT_NE(std::string(error.what()).find("/muscles/2/length_m/7"), std::string::npos)
        << error.what();
  }
}

TEST(ReportHtml, IsOneFileThatNeedsNoOther) {
  const std::string html = report_as_html(sample(), "");
  EXPECT_EQ(count(html, "src="), 0u);
  EXPECT_EQ(count(html, "href="), 0u);
  EXPECT_EQ(count(html, "url("), 0u);
  EXPECT_EQ(count(html, "<script"), 0u);
  EXPECT_EQ(count(html, "http"), count(html, "xmlns=\"http://www.w3.org/2000/svg\""));
  EXPECT_EQ(count(html, "<figure"), count(html, "</figure>"));
  EXPECT_EQ(count(html, "<svg"), 7u);
  EXPECT_EQ(count(html, "<polyline"), 3u * 12u + 3u);
  EXPECT_EQ(count(html, "arm <&"), 0u);
  EXPECT_GE(count(html, "arm &lt;&amp; co&gt;"), 2u);
  EXPECT_EQ(count(html, "nan"), 0u);
  for (int i = 0; i < 12;
       ++i) {  // a label at each of three lines and its title, a row of the table
    EXPECT_EQ(count(html, ">muscle " + std::to_string(i) + "<"), i == 7 ? 8u : 7u)
        << i;  // it swings
  }
}

TEST(Report, SaysWhatATolerancesChoiceIs) {
  Report report = sample();
  FidelityPlan& plan = report.solver.plan.emplace();
  report.solver.tolerance_m = 5e-4;
  report.solver.plan_seconds = 1.5;
  plan.muscles.resize(12);
  plan.muscles[4] = {
      Level::kGeometric, 0, "the carried <shape> is within 0.2 mm", 2e-4, 3e-4, 0, 100, 400};
  plan.muscles[7] = {Level::kDynamic, 2, "1 iteration 0.78 mm off", 1e-4, 4e-4, 5e-5, 300, 300};
  plan.probed = {1, 60};
  plan.checked = {2, 3, 4};
  plan.uniform_iterations = 2;
  plan.uniform_keeps = true;
  plan.work = 1000.0;
  plan.uniform_work = 4000.0;
  const json read = json::parse(report_as_json(report));
  EXPECT_EQ(read["solver"]["fidelity"]["tolerance_m"], 5e-4);
  EXPECT_EQ(read["solver"]["fidelity"]["work_saved"], 0.75);
  EXPECT_EQ(read["solver"]["fidelity"]["frames_checked"], json({2, 3, 4}));
  const json& muscle = read["muscles"][4]["fidelity"];
  EXPECT_EQ(muscle["level"], "geometric");
  EXPECT_EQ(muscle["chosen_because"], plan.muscles[4].reason);
  EXPECT_EQ(muscle["error_probed_m"], 2e-4);
  EXPECT_EQ(muscle["error_checked_m"], 3e-4);
  EXPECT_EQ(muscle["work_saved"], 0.75);
  EXPECT_EQ(read["muscles"][7]["fidelity"]["iterations"], 2);
  EXPECT_EQ(read["muscles"][7]["fidelity"]["error_refined_m"], 5e-5);
  const std::string html = report_as_html(report, "");
  EXPECT_EQ(count(html, "<h2>Fidelity</h2>"), 1u);
  EXPECT_EQ(count(html, "dynamic, 2 iterations"), 1u);
  EXPECT_EQ(count(html, "the carried &lt;shape&gt; is within 0.2 mm"), 1u);
  EXPECT_EQ(count(html, "2 probed frames and 3 others"), 1u);
  EXPECT_EQ(count(html, "75 %"), 2u);
  EXPECT_EQ(count(report_as_html(sample(), ""), "Fidelity"), 0u);
}

// Both errors are stated, and what the banner says is of the one that is in the file.
TEST(ReportHtml, SaysWhichVolumeErrorItIs) {
  const std::string html = report_as_html(sample(), "");
  EXPECT_EQ(count(html, "All bounds met:</b> volume error as written 4.5e-7 of 1e-6 allowed"), 1u);
  EXPECT_EQ(count(html, "<td>4.5e-7</td><td>3e-15</td>"), 12u);
  EXPECT_EQ(count(html, "Volume error as written<tspan"), 1u);
  EXPECT_GE(count(html, "float32"), 2u);
  Report report = sample();
  report.double_precision = true;
  EXPECT_EQ(count(report_as_html(report, ""), "float32"), 0u);
  report.bounds[0].measured = 2e-6;
  EXPECT_EQ(count(report_as_html(report, ""), "1 of 2 bounds not met:</b> volume error as written"),
            1u);
}

TEST(ReportHtml, SaysWhereItComesFromAndLeadsToWhatLiesBesideIt) {
  Report report = sample();
  report.files = {"report.json", "bake.h5", "frames/", "frames/front.mp4"};
  const std::string html = report_as_html(report, "");
  for (const std::string& file : report.files) {
    EXPECT_EQ(count(html, "<a href=\"" + file + "\">" + file + "</a>"), 1u);
  }
  EXPECT_EQ(count(html, "href="), 4u);
  for (const char* what : {"/scenes/arm &lt;1&gt;.toml", "thew bake 'arm &lt;1&gt;.toml'", "9abc",
                           "5678", "2026-01-02T03:04:05Z", ">host<", ">llvmpipe<", "0011223344"}) {
    EXPECT_GE(count(html, what), 1u) << what;
  }
}

TEST(ReportHtml, VerdictFollowsTheBounds) {
  Report report = sample();
  EXPECT_EQ(count(report_as_html(report, ""), "All bounds met"), 1u);
  report.bounds[1].measured = 6.2e-4;
  report.worst = {{"penetration", 6.2e-4, 57, "brachialis"}};
  EXPECT_EQ(count(report_as_html(report, ""),
                  "penetration is 0.62 mm in frame 57 (brachialis), allowed 0.5 mm"),
            1u);
  report.worst.clear();
  const std::string bad = report_as_html(report, "");
  EXPECT_EQ(count(bad, "1 of 2 bounds not met:</b> penetration is 0.62 mm, allowed 0.5 mm"), 1u);
  EXPECT_EQ(count(bad, "All bounds met"), 0u);
  report.bounds.clear();
  EXPECT_EQ(count(report_as_html(report, ""), "sets no quality bounds"), 1u);
}

TEST(ReportHtml, StandsAnEmptyBakeAndOneFrame) {
  EXPECT_EQ(count(report_as_html(Report(), ""), "<polyline"), 0u);
  Report report = sample();
  report.frames = {5};
  for (Report::Muscle& muscle : report.muscles) {
    for (auto* values :
         {&muscle.length_m, &muscle.belly_area_ratio, &muscle.volume_error_written}) {
      values->resize(1);
    }
  }
  report.skin.penetration_m.resize(1);
  report.contact.intersecting_triangle_pairs.resize(1);
  const std::string html = report_as_html(report, "");
  EXPECT_EQ(count(html, "<circle"), 38u);
  EXPECT_EQ(count(html, "nan"), 0u);
}

std::string decode_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int have = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    have += 6;
    if (have >= 8) bytes += static_cast<char>(bits >> (have -= 8) & 255);
  }
  return bytes;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ReportHtml, CarriesThePictureAndIsWritten) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("thew_report_" + std::to_string(getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (std::string png : {"1", "12", "123", "1234"}) {
    png += std::string("\x89PNG\0\xff", 6);
    std::ofstream(folder / "sheet.png", std::ios::binary) << png;
    write_report(folder, sample(), folder / "sheet.png");
    const std::string html = bytes_of(folder / "report.html");
    const std::string before = "src=\"data:image/png;base64,";
    const std::size_t from = html.find(before) + before.size();
    EXPECT_EQ(decode_base64(html.substr(from, html.find('"', from) - from)), png);
  }
  EXPECT_EQ(bytes_of(folder / "report.json"), report_as_json(sample()));
  std::ofstream(folder / "file") << "in the way";
  EXPECT_THROW(write_report(folder / "file", sample(), ""), Error);
  fs::remove_all(folder);
}

/// The points of the first line of a chart.
std::vector<std::pair<double, double>> points(const std::string& svg) {
  const std::size_t from = svg.find("points=\"") + 8;
  std::istringstream in(svg.substr(from, svg.find('"', from) - from));
  std::vector<std::pair<double, double>> points;
  char comma;
  for (double x, y; in >> x >> comma >> y;) points.emplace_back(x, y);
  return points;
}

TEST(Chart, LinesAreWhereTheirValuesAre) {
  const auto p =
      points(draw_chart(LineChart{"t", "mm", {1, 3, 5}, {{"a", {0.0, 5.0, 10.0}}}, false, {}}));
  ASSERT_EQ(p.size(), 3u);
  EXPECT_NEAR(p[1].first, (p[0].first + p[2].first) / 2, 0.06);
  EXPECT_NEAR(p[1].second, (p[0].second + p[2].second) / 2, 0.06);
  EXPECT_LT(p[2].second, p[0].second - 100);  // up the page
}

TEST(Chart, DecadesAreEvenAndZeroIsOnTheFloor) {
  const auto p = points(
      draw_chart(LineChart{"t", "", {1, 2, 3, 4}, {{"a", {0.0, 1e-12, 1e-9, 1e-6}}}, true, {}}));
  ASSERT_EQ(p.size(), 4u);
  EXPECT_NEAR(p[1].second - p[2].second, p[2].second - p[3].second, 0.11);
  EXPECT_GT(p[0].second, p[1].second);
}

TEST(Chart, NumbersAreReadable) {
  EXPECT_EQ(readable(1e-9), "1e-9");
  EXPECT_EQ(readable(6.6613e-16), "6.66e-16");
  EXPECT_EQ(readable(-0.25), "-0.25");
  EXPECT_EQ(readable(1e100), "1e+100");
  EXPECT_EQ(readable(0.0), "0");
}

TEST(Chart, LabelsDoNotLieOnOneAnotherNorBesideThePaper) {
  const std::string name = "extensor carpi radialis longus right";
  for (const std::size_t lines : {12, 24}) {
    LineChart chart{"t", "", {1, 2}, {}, false, {}};
    for (std::size_t i = 0; i < lines; ++i) chart.lines.push_back({name, {0.0, 1.0}});
    const std::string svg = draw_chart(chart);
    std::vector<double> heights;
    for (std::size_t at = 0; (at = svg.find("class=\"label\"", at)) != std::string::npos; ++at) {
      heights.push_back(std::stod(svg.substr(svg.rfind(" y=\"", at) + 4)));
      const double x = std::stod(svg.substr(svg.rfind(" x=\"", at) + 4));
      EXPECT_LE(x + 6.0 * static_cast<double>(name.size()), 640.0);
    }
    ASSERT_EQ(heights.size(), lines);
    std::sort(heights.begin(), heights.end());
    for (std::size_t i = 1; i < lines; ++i) EXPECT_GE(heights[i] - heights[i - 1], 13.5);
    EXPECT_GE(heights[0], 20.0);  // below the title
  }
}

}  // namespace
}  // namespace thew::tests
