// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdio>
#include <memory>

#include "sim/durable_file.h"
#include "tools/chart_plot.h"
#include "tools/commands.h"
#include "tools/progress.h"

namespace thew {

ExitCode chart_command(const CommandOptions& options) {
  const ProgressStyle style = parse_progress(options.progress, isatty(STDERR_FILENO) != 0);
  create_folders(options.out);
  const FolderLock lock(options.out);
  ChartAsk ask{.scene = options.input, .threads = thread_count(options.threads)};
  std::unique_ptr<Progress> progress;
  ask.on_step = [&](int done, int total) {
    if (!progress) progress = std::make_unique<Progress>(style, "charting", total, stderr);
    progress->step(done, done);
  };
  const Chart chart = run_chart(ask);
  progress.reset();
  write_durably(options.out / "chart.csv", chart_csv(chart));
  write_durably(options.out / "chart.json", chart_json(chart));
  write_durably(options.out / "chart.svg",
                draw_cost(chart, &ChartPoint::largest_mm, "largest position error, mm"));
  write_durably(options.out / "chart.html", chart_html(chart));
  std::printf("%s\n", (options.out / "chart.html").c_str());
  return ExitCode::kDone;
}

}  // namespace thew
