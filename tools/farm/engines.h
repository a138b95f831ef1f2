// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tools/base/exit_code.h"
#include "tools/farm/graph.h"

namespace thew::tools {

// `program` is thew; `overwrite`: also over files that Thew did not write.

/// Writes submit.sh with what it submits, into a new folder N of `folder` (or the last one, where
/// it has not been submitted): tasks of an earlier one may still wait. Returns submit.sh.
std::filesystem::path write_slurm(const Graph& graph, const std::filesystem::path& program,
                                  const std::filesystem::path& folder, bool overwrite = false);

/// Writes a job bundle of Open Job Description 2023-09 for each shot, FOLDER/shots/SHOT, and one
/// for the report, FOLDER/report. Returns the templates, the report's last.
std::vector<std::filesystem::path> write_openjd(const Graph& graph, const Jobs& jobs,
                                                const std::filesystem::path& program,
                                                const std::filesystem::path& folder,
                                                bool overwrite = false);

/// Runs the tasks on this machine, as many at once as `threads` and its memory allow; each prints
/// into LOGS/TASK.log. A task that fails takes those after it along, all others are done.
/// kDifferent where the report says that a bake misses a bound. Error with the code of the first
/// task that failed; Error(kRetry) after a signal, which the tasks get too.
ExitCode run_here(const Graph& graph, const std::filesystem::path& program,
                  const std::filesystem::path& logs, int threads);

}  // namespace thew::tools
