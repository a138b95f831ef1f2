// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <chrono>

#include "sim/durable_file.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/paper_report.h"

namespace thew {

ExitCode paper_command(const CommandOptions& options, bool quick,
                       const std::filesystem::path& cow) {
  const auto begin = std::chrono::steady_clock::now();
  Progress progress(parse_progress(options.progress, isatty(STDERR_FILENO) != 0), "reproducing",
                    paper_steps(quick), stderr);
  create_folders(options.out);
  const FolderLock lock(options.out);
  PaperReport report(options.out, quick, cow, progress);
  paper_ball(report);
  paper_bodies(report);
  paper_errors(report);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  report.write(seconds.count());
  return ExitCode::kDone;
}

}  // namespace thew
