// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/paper/command.h"

#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/lab/paper/ball.h"

namespace thew::tools {

void run_paper(PaperReport& report) {
  const PaperTimes times = time_balls(report);  // first, while nothing else runs
  // Each thread is timed by its own clock; the whole run gives each a quiet machine as well.
  std::future<BallElements> elements =
      std::async(report.quick ? std::launch::async : std::launch::deferred,
                 [&] { return run_elements(times, report); });
  report.chapter(1);
  paper_bodies(report);
  report.chapter(2);
  paper_errors(report);
  report.chapter(0);
  paper_ball(times, elements, report);
}

ExitCode paper_command(const CommandOptions& options, bool quick,
                       const std::filesystem::path& cow) {
  const auto begin = std::chrono::steady_clock::now();
  Progress progress(parse_progress(options.progress, isatty(STDERR_FILENO) != 0), "reproducing",
                    paper_steps(quick), stderr);
  create_folders(options.out);
  const FolderLock lock(options.out);
  PaperReport report(options.out, quick, cow, options.overwrite, progress);
  run_paper(report);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  report.write(seconds.count());
  const std::string page = (options.out / "report.html").string();
  if (options.json) {
    print_json({{"report", page}, {"verdicts", (options.out / "verdicts.csv").string()}});
  } else {
    print(page + "\n");
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
