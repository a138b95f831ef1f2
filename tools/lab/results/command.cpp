// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/results/command.h"

#include <unistd.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/lab/results/results.h"

namespace thew::tools {
namespace {

constexpr int kQuickFrames = 12;  // the last frame of a quick run's flexion

// What README.md states and only a test measures.
Table tested_table() {
  return {
      "",
      "Figures that tests alone hold",
      "",
      {"what", "tested by"},
      {{"folds of a muscle, and its crossings with itself", "`tests/property/sim_arm.cpp`"},
       {"skin within 3 cm of the elbow's tip slides over the ulna; sections of the forearm's "
        "skin as it turns",
        "`tests/property/sim_skin_arm.cpp`"},
       {"a ball between planes at 30, 10 and 5 % of its height; the elbow flexed in one frame; "
        "a fist at 10 m/s; a skin that is too tight",
        "`tests/stress/sim_contact.cpp`"},
       {"a ball from a cache that flattens on muscles and skin; the arm by its own cached bones",
        "`tests/unit/sim/cached.cpp`, `tests/property/sim_cached_arm.cpp`"},
       {"integrators end in one limit", "`tests/property/sim_integrators.cpp`"}}};
}

// A message names its scene by where that lies on this machine.
void name_scene(const std::string& path, Table& table) {
  for (auto& row : table.rows) {
    for (std::string& cell : row) {
      const auto at = cell.find(path);
      if (at != std::string::npos) cell.replace(at, path.size(), "SCENE");
    }
  }
}

}  // namespace

ExitCode results_command(const CommandOptions& options, bool quick) {
  const auto begin = std::chrono::steady_clock::now();
  const std::filesystem::path arm = own_asset("arm/arm.toml");
  const int threads = thread_count(options.threads);
  using Part = std::pair<const char*, std::function<std::vector<Table>()>>;
  std::vector<Part> parts = {
      {"speed", [&] { return std::vector{speed_table(arm, quick)}; }},
      {"flexion",
       [&] { return std::vector{flexion_table(arm, quick ? kQuickFrames : 0, threads)}; }},
      {"paper", [&] { return paper_tables(quick); }},
      {"related", [&] { return related_tables(quick); }},
      {"bar", [] { return std::vector{bar_table()}; }},
      {"peers", [&] { return peer_tables(arm); }},
      {"tolerance", [&] { return tolerance_tables(arm); }},
      {"chart", [&] { return chart_tables(arm, threads); }},
      {"failure", [&] { return std::vector{failure_table(threads)}; }},
      {"what tests hold", [] { return std::vector{tested_table()}; }}};
  // Of a quick run: speed, flexion, paper, related, and what tests hold.
  if (quick) parts.erase(parts.begin() + 4, parts.end() - 1);
  ResultsHead head = results_head(options.commit, quick);
  std::vector<Table> tables;
  {
    Progress progress(parse_progress(options.progress, isatty(STDERR_FILENO) != 0), "measuring",
                      static_cast<int>(parts.size()), stderr);
    for (size_t k = 0; k < parts.size(); ++k) {
      for (Table& table : parts[k].second()) {
        name_scene(arm.string(), table);
        tables.push_back(std::move(table));
      }
      head.missing.clear();  // the page is there after each part: half an hour may end early
      for (size_t left = k + 1; left < parts.size(); ++left) {
        head.missing += (head.missing.empty() ? "" : ", ") + std::string(parts[left].first);
      }
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      head.minutes = seconds.count() / 60.0;
      head.load_after = load_average();
      replace_durably(options.out, results_page(head, tables));
      progress.step(static_cast<int>(k) + 1);
    }
  }
  if (options.json) {
    print_json({{"results", options.out.string()}});
  } else {
    print(options.out.string() + "\n");
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
