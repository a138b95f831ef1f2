// SPDX-License-Identifier: Apache-2.0
//
// Tables of what thew_bench and thew-lab chart measure.
#include <nlohmann/json.hpp>

#include "tools/base/temporary_folder.h"
#include "tools/lab/bench/benches.h"
#include "tools/lab/chart/plot.h"
#include "tools/lab/chart/skin_chart.h"
#include "tools/lab/results/results.h"

namespace thew::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kRuns = 3;            // of which times are the medians
constexpr double kTolerance = 0.5;  // mm

std::string text(const Json& value, int digits = 3) {
  return value.is_number_float() ? number(value.get<double>(), digits) : value.dump();
}

const std::string kBench = "`thew_bench SCENE`", kUntested = "none, it is a time";

// What the skin costs and what its volume adds.
void add_skin(const std::string& scene, Table& table) {
  const Json skin = skin_price(scene, kRuns);
  const std::string by = "`thew_bench SCENE --skin`";
  table.rows.push_back({"the skin's time with its volume kept over without",
                        text(skin["ratio_of_volume"]) + " (" +
                            text(skin["cpu_ms_per_frame_with_its_volume"]) + " and " +
                            text(skin["cpu_ms_per_frame"]) + " ms a frame)",
                        by, kUntested});
  table.rows.push_back({"volume error of what the skin encloses, at the last frame",
                        text(skin["volume_error"], 2), by, "`tests/property/sim_arm.cpp`"});
}

void add_copies(const std::string& scene, Table& table) {
  const TemporaryFolder folder("results");
  const Json copies = contact_of_copies(scene, folder.path() / "copies.svg");
  for (const Json& one : copies["copies"]) {
    table.rows.push_back(
        {"contact of " + text(one["copies"]) + " of it in one scene over n log n from one",
         text(one["over_n_log_n"]) + " (" + text(one["contact_ms_per_frame"]) + " ms a frame; " +
             text(one["searches_per_node_and_frame"]) +
             " searches for each node and frame, the price of " +
             text(one["queries_worth_per_node_and_frame"]) + " nearest-point queries)",
         "`thew_bench SCENE --copies OUT.svg`", kUntested});
  }
}

// What activation costs in the arm's curl, which has it. Small scenes have maps and props.
void add_activation(const std::filesystem::path& arm, Table& table) {
  const Json price = price_of_features((arm.parent_path() / "curl.toml").string(), kRuns);
  table.rows.push_back({"`curl.toml` with its activation over without",
                        text(price["ratio_of_activation"]), "`thew_bench SCENE --features`",
                        kUntested});
}

}  // namespace

Table speed_table(const std::filesystem::path& scene, bool quick) {
  const Json speed = speed_of(scene.string(), quick ? 1 : kRuns);
  Table table{"",
              "Muscles with their collisions: speed, and accuracy at that speed",
              "",
              figure_head(),
              {}};
  const auto add = [&](const std::string& what, const std::string& figure,
                       const std::string& test = kUntested) {
    table.rows.push_back({what, figure, kBench, test});
  };
  add("contact over no contact", text(speed["ratio_to_no_contact"]));
  add("exact volume over none", text(speed["ratio_to_no_volume"]));
  add("with friction over without", text(speed["ratio_of_friction"]));
  add("each muscle's contact with itself over without", text(speed["ratio_of_self_contact"]));
  add("frames per CPU second (the paper's machine: 32)", text(speed["frames_per_cpu_second"]));
  add("CPU ms a frame", text(speed["cpu_ms_per_frame"]));
  add("sag of the first muscle held horizontally", text(speed["sag_mm"], 2) + " mm");
  const Json& error = speed["error_mm"];
  add("position against the refined step (8 substeps, 40 iterations), all nodes and frames",
      text(error["rms"], 2) + " mm RMS, " + text(error["max"], 2) + " mm at most, in frame " +
          text(error["in_frame"]),
      "`tests/property/sim_arm.cpp`, half the step");
  if (quick) return table;
  add_skin(scene.string(), table);
  add_copies(scene.string(), table);
  add_activation(scene, table);
  return table;
}

std::vector<Table> tolerance_tables(const std::filesystem::path& scene) {
  const std::string by = "`thew_bench SCENE --tolerance 0.5`",
                    test = "`tests/property/sim_arm.cpp`";
  Table table{
      "", "A tolerance of 0.5 mm in place of a step", "Times without the skin.", figure_head(), {}};
  const auto add = [&](const std::string& what, const std::string& figure) {
    table.rows.push_back({what, figure, by, test});
  };
  Json found;
  try {
    found = tolerance_of(scene.string(), kTolerance, {}, kRuns);
  } catch (const Error& error) {  // what cannot be promised is a figure too
    if (error.code() != ErrorCode::kUsage) throw;
    add("refused", error.what());
    return {table};
  }
  add("largest error of any node and frame", text(found["error_mm"], 2) + " mm");
  add("volume error", text(found["volume_error"], 2));
  for (const auto& [key, what] :
       {std::pair{"uniform_within_the_tolerance", "cheapest one step for all within the tolerance"},
        {"uniform_with_the_same_error", "cheapest one step for all that is as right"}}) {
    if (!found.contains(key)) continue;
    const Json& one = found[key];
    add("time over that of the " + std::string(what),
        text(one["tolerance_over_it"]) + " (" + text(found["cpu_ms_per_frame"]) + " and " +
            text(one["cpu_ms_per_frame"]) + " ms a frame; " + text(one["substeps"]) +
            " substeps, " + text(one["iterations"]) + " iterations, " + text(one["error_mm"], 2) +
            " mm off)");
  }
  add("probes, once", text(found["probes"]["cpu_seconds"], 2) + " CPU s");
  Table muscles{"",
                "The same by muscle",
                "Measured alone by " + by + ".",
                {"muscle", "level", "iterations", "error, mm", "because"},
                {}};
  for (const Json& one : found["muscles"]) {
    muscles.rows.push_back({one["name"], one["level"], text(one["iterations"]),
                            text(one["error_mm"], 2), one["because"]});
  }
  return {table, muscles};
}

std::vector<Table> chart_tables(const std::filesystem::path& scene, int threads) {
  const Chart chart = run_chart({.scene = scene, .threads = threads});
  const SkinChart skin = run_skin_chart({.scene = scene, .threads = threads});
  std::vector<Table> tables = {points_of(chart), refinements_of(chart), points_of(skin)};
  for (Table& table : tables) {
    table.title = "The chart: " + table.title;
    table.note +=
        " Measured alone by `thew-lab chart SCENE --out DIR`; tested by "
        "`tests/unit/tools/lab/chart.cpp` on a small scene.";
  }
  return tables;
}

}  // namespace thew::tools
