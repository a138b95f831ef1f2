// SPDX-License-Identifier: Apache-2.0
//
// Every measured figure on one Markdown page, each with the command that measures it alone and the
// test that holds it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/lab/base/table.h"

namespace thew::tools {

/// Where and of what the figures were taken.
struct ResultsHead {
  std::string date;       ///< "2026-11-24", UTC
  std::string processor;  ///< its name, and how many of them
  std::string compiler;
  std::string commit;
  double load_before = 0.0, load_after = 0.0;  ///< mean of processes that ran, in the last minute
  double minutes = 0.0;                        ///< that all of it took
  bool quick = false;
  std::string missing = {};  ///< parts of an interrupted run, "bar, peers"
};
/// Of this machine and program, as it is now.
ResultsHead results_head(const std::string& commit, bool quick);
double load_average();

std::string results_page(const ResultsHead& head, const std::vector<Table>& tables);

/// Head of the tables whose rows are: what, the figure, what measures it alone, what tests it.
const std::vector<std::string>& figure_head();

/// The scene's flexion baked: errors of volume, lengths, penetrations, crossings. Lengths are set
/// against anatomy where the scene has the arm's muscles. `last`: frame, 0 for the scene's own.
Table flexion_table(const std::filesystem::path& scene, int last, int threads);
/// Price of contact and exact volume, sag, distance from the refined step (thew_bench SCENE); in
/// whole runs also of the skin (--skin), of copies (--copies), and of the activation of the curl
/// beside the scene (--features).
Table speed_table(const std::filesystem::path& scene, bool quick);
/// What a tolerance of 0.5 mm chooses (thew_bench SCENE --tolerance 0.5), by muscle.
std::vector<Table> tolerance_tables(const std::filesystem::path& scene);
/// Each setting of the chart (thew-lab chart), and each integrator's refinement.
std::vector<Table> chart_tables(const std::filesystem::path& scene, int threads);
/// Tables and verdicts of thew-lab paper.
std::vector<Table> paper_tables(bool quick);
/// Zones of the bar beside finite elements (thew_peers --bar).
Table bar_table();
/// The paper's related work (thew-lab paper --related): methods, claims, truths, the arm's
/// sections.
std::vector<Table> related_tables(bool quick);
/// Where methods fail (thew-lab chart --stability of the paper's ball): cells by verdict.
Table failure_table(int threads);
/// Bullet beside ours (thew_peers), where that program lies beside this one; else none.
std::vector<Table> peer_tables(const std::filesystem::path& scene);

}  // namespace thew::tools
