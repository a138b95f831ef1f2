// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/page.h"

#include <cstdio>

#include "sim/cache/durable_file.h"
#include "tools/base/text.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/related/claims.h"

namespace thew::tools {
namespace {

constexpr const char* kBall = "ball_1470";
constexpr double kExact = 1e-9;  // volume errors below are of rounding

std::string share(double value) { return value < 0.0 ? "" : number(100.0 * value); }
std::string any(double value) { return value < 0.0 ? "" : number(value); }

std::string setting_of(const RelatedRun& run, bool has_step) {
  std::string text = run.dial;
  if (has_step) text += (text.empty() ? "" : ", ") + std::to_string(run.steps) + " steps";
  return text;
}

ChartPoint point_of(const RelatedRun& run, const std::string& label, int colour) {
  ChartPoint point;
  point.setting.integrator = run.method;
  point.setting.volume = run.volume_error < kExact ? "exact" : "none";
  point.peer = run.method;
  point.label = label;
  point.colour = colour;
  point.failure = run.failure;
  point.milliseconds = run.milliseconds;
  point.volume_error = run.volume_error;
  point.percent = run.distance < 0.0 ? -1.0 : 100.0 * run.distance;
  return point;
}

std::vector<std::string> run_row(const RelatedRun& run, bool has_step) {
  const std::string setting = setting_of(run, has_step);
  if (!run.failure.empty()) return {run.method, setting, run.failure, "", "", ""};
  return {run.method,
          setting,
          number(run.milliseconds),
          number(run.volume_error, 2),
          share(run.distance),
          run.volume_rate > 0.0 ? number(run.volume_rate, 2) : ""};
}

}  // namespace

Chart chart_of(const Study& study, const std::string& key) {
  const StudiedScene& in = study.scenes[study.scene(key)];
  Chart chart;
  chart.scene = in.scene.name;
  chart.muscles = 1;
  chart.nodes = static_cast<int>(in.scene.surface.vertices.size());
  chart.frames = in.scene.frames();
  int colour = 0;
  for (const RelatedRun& run : in.thew) {
    if (run.method == kThewBare) continue;  // the conventional one's row
    chart.points.push_back(point_of(run, run.method, colour));
    chart.points.back().peer = "Thew";
  }
  for (size_t m = 0; m < study.methods.size(); ++m) {
    const RelatedSweep& found = in.sweeps[m];
    if (found.runs.empty()) continue;
    ++colour;
    const std::string& name = study.methods[m].name;
    if (found.best < 0) {
      chart.points.push_back(point_of(found.runs.back(), found.runs.back().failure, colour));
      continue;
    }
    chart.points.push_back(point_of(found.runs[found.best], name, colour));
    if (found.cheapest != found.best) {
      chart.points.push_back(point_of(found.runs[found.cheapest], name + ", cheapest", colour));
    }
  }
  return chart;
}

Table summary_of(const Study& study) {
  Table table{"related.csv",
              "All methods: the ball at its best and its cheapest stable setting, and the rest",
              "Distance: mean of the surface's free nodes from the neo-Hookean truth, % of the "
              "radius (of the muscle's: its half thickness). Volume: largest |V/V0 - 1| of all "
              "frames. Step: the largest that is stable at any setting. Momentum: gained by a free "
              "body, share of what its nodes carry. Stiffer: against a stretch that keeps the "
              "volume, over the same without what holds the volume.",
              {"method", "what", "best setting", "ms", "volume", "distance %", "cheapest setting",
               "ms", "volume", "distance %", "step ms", "momentum", "stiffer"},
              {}};
  const StudiedScene& ball = study.scenes[study.scene(kBall)];
  std::vector<const StudiedScene*> others;
  for (const StudiedScene& in : study.scenes) {
    if (&in == &ball || !in.whole) continue;
    others.push_back(&in);
    table.head.push_back(in.scene.key + " volume");
    table.head.push_back(in.scene.key + " distance %");
  }
  for (size_t m = 0; m < study.methods.size(); ++m) {
    const RelatedMethod& method = study.methods[m];
    std::vector<std::string>& row = table.rows.emplace_back();
    row = {method.name, method.what};
    for (const bool best : {true, false}) {
      const RelatedRun* const run =
          best ? study.best(method.name, kBall) : study.cheapest(method.name, kBall);
      if (!run) {
        const bool tried = !ball.sweeps[m].runs.empty();
        row.insert(row.end(), {tried ? ball.sweeps[m].runs.back().failure : "", "", "", ""});
        continue;
      }
      row.insert(row.end(), {setting_of(*run, method.has_step), number(run->milliseconds),
                             number(run->volume_error, 2), share(run->distance)});
    }
    const double step = ball.sweeps[m].largest_step;
    row.insert(row.end(), {method.has_step && step > 0.0 ? number(1e3 * step) : "",
                           any(study.momentum[m]), any(study.stiffening[m])});
    for (const StudiedScene* in : others) {
      const RelatedRun* const run = study.best(method.name, in->scene.key);
      row.push_back(run ? number(run->volume_error, 2) : "");
      row.push_back(run ? share(run->distance) : "");
    }
  }
  return table;
}

Table claims_of(const Study& study) {
  Table table{
      "claims.csv",
      "What the paper says of its related work and of itself",
      "Each verdict is derived from the figures beside it. Printed: a table or figure of the "
      "paper says it. Its authors: the method's own paper does. Paraphrase: the sense of the "
      "paper's sidebar in our words; its text was not at hand. Ours: what the comparison "
      "comes to.",
      {"claim", "said by", "verdict", "figures"},
      {}};
  for (const RelatedClaim& claim : judge_claims(study)) {
    table.rows.push_back({claim.claim, claim.source, claim.verdict, claim.figures});
  }
  return table;
}

Table truths_of(const Study& study) {
  Table table{
      "truths.csv",
      "The truth that distances are from",
      "Neo-Hookean, a thousand times as hard to compress as to shear, quadratic elements on "
      "meshes each twice as fine; the limit by Richardson's extrapolation. Error: mean "
      "distance of the finest mesh's nodes from the limit, % of the size.",
      {"scene", "elements", "from mesh to mesh %", "order", "error %", "volume", "converged"},
      {}};
  for (const StudiedScene& in : study.scenes) {
    const Truth& truth = in.truth;
    if (!in.whole || !truth.is_known()) continue;
    std::string elements, apart;
    for (const int count : truth.elements) elements += std::to_string(count) + " ";
    for (const double a : truth.apart) apart += share(a / in.scene.size) + " ";
    table.rows.push_back({in.scene.name, elements, apart,
                          truth.elements.size() > 2 ? number(truth.order) : "taken as 1",
                          share(truth.error / in.scene.size), number(truth.volume_error, 2),
                          truth.converged ? "yes" : "no"});
  }
  return table;
}

std::vector<Table> runs_of(const Study& study) {
  std::vector<Table> tables;
  for (const StudiedScene& in : study.scenes) {
    Table table{in.scene.key + ".csv",
                "Every setting: " + in.scene.name + ", " +
                    std::to_string(in.scene.surface.triangles.size()) + " triangles",
                in.whole ? ""
                         : "Each method at the setting that was best with the smallest ball; "
                           "elements of the largest for 3 frames.",
                {"method", "setting", "ms a frame", "volume error", "distance %",
                 "volume that v loses, 1/s"},
                {}};
    for (const RelatedRun& run : in.thew) table.rows.push_back(run_row(run, true));
    for (size_t m = 0; m < study.methods.size(); ++m) {
      for (const RelatedRun& run : in.sweeps[m].runs) {
        table.rows.push_back(run_row(run, study.methods[m].has_step));
      }
    }
    tables.push_back(std::move(table));
  }
  return tables;
}

void write_study(const Study& study, double seconds,
                 const std::function<std::filesystem::path(const std::string&)>& place) {
  std::string body =
      "<p class=\"soft\">The methods that Hong, Jung, Choi and Welch (2006) name beside their own, "
      "and two of today, each as small as its paper allows, on the same meshes, springs, obstacles "
      "and drag; all surfaces by Thew's own spring kernel. Thew's own rows pay for contact with "
      "meshes, which the others' formulas do not. Times are CPU time of one thread.</p>\n";
  const auto add = [&](const Table& table) {
    write_durably(place(table.file), csv_of(table));
    body += html_of(table);
  };
  add(claims_of(study));
  const auto draw = [&](const std::string& key, const char* file, double ChartPoint::*error,
                        const std::string& what) {
    const std::string svg = draw_cost(chart_of(study, key), error, what);
    const std::filesystem::path at = place(std::string(file) + ".svg");
    write_durably(at, svg);
    const std::string diagnosis = write_picture(place(std::string(file) + ".png"), at);
    if (!diagnosis.empty()) std::fprintf(stderr, "thew: %s\n", diagnosis.c_str());
    body += "<figure>" + svg + "</figure>\n";
  };
  draw(kBall, "related", &ChartPoint::percent, "distance, % of the radius");
  draw(kBall, "related_volume", &ChartPoint::volume_error, "largest volume error");
  draw("flexed", "related_flexed", &ChartPoint::percent, "distance, % of half the thickness");
  add(summary_of(study));
  if (!study.arm.empty()) add(sections_of(study.arm));
  add(truths_of(study));
  for (const Table& table : runs_of(study)) add(table);
  if (study.quick) {
    body += "<p class=\"soft\">The quick run: two scenes, one setting each, a coarser truth.</p>\n";
  }
  body += "<p class=\"soft\">Made in " + number(seconds) + " s.</p>\n";
  write_durably(place("related.html"),
                html_page("The paper's related work, side by side",
                          "main { max-width: 1180px; } td { white-space: normal; } .cost { width: "
                          "860px; max-width: 100%; }",
                          body));
}

}  // namespace thew::tools
