// SPDX-License-Identifier: Apache-2.0
//
// Tables of what thew-lab paper, its --related, chart --stability and thew_peers measure.
#include <nlohmann/json.hpp>

#include "rig/text.h"
#include "tools/base/options.h"
#include "tools/base/temporary_folder.h"
#include "tools/lab/failure/maps.h"
#include "tools/lab/paper/command.h"
#include "tools/lab/paper/report.h"
#include "tools/lab/peers/bar_chart.h"
#include "tools/lab/related/page.h"
#include "tools/lab/results/results.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::uintmax_t kMostBytes = 1 << 20;  // of what thew_peers writes

std::string ratio_text(const Json& ours) {
  return number(ours["times_as_fast"].get<double>()) + " (" +
         number(ours["cpu_ms_per_frame"].get<double>()) + " ms a frame; volume error " +
         number(ours["volume_error"].get<double>(), 2) + ")";
}

void add_rows(const std::string& what, const Json& found, Table& table) {
  const Json& peer = found["peer"];
  for (const Json& ours : found["ours"]) {
    table.rows.push_back({what, ours["setting"], ratio_text(ours),
                          peer["setting"].get<std::string>() + " (" +
                              number(peer["cpu_ms_per_frame"].get<double>()) +
                              " ms a frame; volume error " +
                              number(peer["volume_error"].get<double>(), 2) + ")"});
  }
}

// Of ball.csv, whose first column is quoted where it holds a comma.
Table ball_table(const std::string& csv) {
  Table table{"",
              "Squeezed ball: ours, Bullet's soft body, finite elements",
              "Distance of the nodes from the converged neo-Hookean ball, mean. Measured alone by "
              "`thew_peers --chart DIR`; tested by `tests/unit/tools/lab/fem.cpp`, the elements.",
              {"method", "CPU ms a frame", "% of the radius", "volume error"},
              {}};
  for (size_t begin = csv.find('\n') + 1; begin < csv.size();) {
    const size_t end = std::min(csv.find('\n', begin), csv.size());
    std::vector<std::string> row(1);
    bool quoted = false;
    for (const char c : csv.substr(begin, end - begin)) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        row.emplace_back();
      } else {
        row.back() += c;
      }
    }
    table.rows.push_back(row);
    begin = end + 1;
  }
  return table;
}

}  // namespace

std::vector<Table> paper_tables(bool quick) {
  const TemporaryFolder folder("results");
  Progress progress(ProgressStyle::kNone, "", paper_steps(quick), stderr);
  PaperReport report(folder.path(), quick, {}, false, progress);
  run_paper(report);
  std::vector<Table> tables = report.tables();
  for (Table& table : tables) {
    table.title = "The paper: " + table.title;
    table.note += std::string(table.note.empty() ? "" : " ") +
                  "Measured alone by `thew-lab paper --out DIR`; tested by "
                  "`tests/unit/tools/lab/paper_long.cpp`.";
  }
  return tables;
}

std::vector<Table> related_tables(bool quick) {
  const Study study = run_study(own_asset("paper"), own_asset("arm/arm.toml"), quick, [] {});
  std::vector<Table> tables = {claims_of(study), summary_of(study), sections_of(study.arm),
                               truths_of(study)};
  for (Table& table : tables) {
    table.title = "Related work: " + table.title;
    table.note +=
        " Measured alone by `thew-lab paper --related --out DIR`; tested by "
        "`tests/unit/tools/lab/rivals.cpp` (each method), `tests/unit/tools/lab/related.cpp`.";
  }
  return tables;
}

Table failure_table(int threads) {
  const std::vector<StabilityMap> maps =
      run_maps({.scene = own_asset("paper/ball.toml"), .threads = threads});
  Table table = verdicts_of(maps);
  table.title = "The map of failure: " + table.title;
  table.note +=
      " Which region fails by what, and what Thew does there, is on the page of `thew-lab chart "
      "assets/paper/ball.toml --stability --out DIR`, which measures this alone; tested by "
      "`tests/unit/tools/lab/failure.cpp`.";
  return table;
}

Table bar_table() {
  const TemporaryFolder folder("results");
  Table table = draw_bar_chart(folder.path());
  table.note +=
      " Hollow: without the carried shape's stand-in for an inside. Measured alone by `thew_peers "
      "--bar DIR`; tested by `tests/property/tools_bar.cpp`.";
  return table;
}

std::vector<Table> peer_tables(const fs::path& scene) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "thew_peers";
  if (!fs::exists(program)) return {};  // built only where Bullet is installed
  const TemporaryFolder folder("results");
  const fs::path file = folder.path() / "peers.json";
  for (const auto& words :
       {std::vector<std::string>{program.string(), scene.string(), file.string()},
        {program.string(), "--chart", folder.path().string()}}) {
    if (run_program(words) == 0) continue;
    throw Error(ErrorCode::kSolver, program.string() + " failed; run it by itself to see why");
  }
  const Json found = Json::parse(read_whole(file, kMostBytes));
  Table table{"",
              "How many times as fast as Bullet's soft body",
              "Bullet at its most accurate stable setting of a grid; on the arm both are without "
              "contact. Measured alone by `thew_peers SCENE`; no test holds them.",
              {"what", "ours", "times as fast", "Bullet"},
              {}};
  for (const Json& ball : found["balls"]) {
    add_rows("squeezed ball, " + ball["nodes"].dump() + " nodes", ball, table);
  }
  add_rows("the scene", found["arm"], table);
  return {table, ball_table(read_whole(folder.path() / "ball.csv", kMostBytes))};
}

}  // namespace thew::tools
