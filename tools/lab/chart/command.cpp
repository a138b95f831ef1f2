// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/chart/command.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/lab/chart/plot.h"

namespace thew::tools {

namespace fs = std::filesystem;

namespace {

// The page, or as JSON all files.
void tell(const CommandOptions& options, const std::vector<std::string>& files) {
  if (!options.json) return print((options.out / files[0]).string() + "\n");
  nlohmann::ordered_json json = {{"files", nlohmann::ordered_json::array()}};
  for (const std::string& file : files) json["files"].push_back((options.out / file).string());
  print_json(json);
}

}  // namespace

ExitCode chart_command(const CommandOptions& options) {
  const ProgressStyle style = parse_progress(options.progress, isatty(STDERR_FILENO) != 0);
  create_folders(options.out);
  const FolderLock lock(options.out);
  std::vector<fs::path> claimed;
  for (const char* ending : {".csv", ".json", ".svg", ".png", ".html"}) {
    claimed.push_back(options.out / (std::string("chart") + ending));
  }
  claim(claimed, options.overwrite);
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
  const std::string diagnosis = write_picture(options.out / "chart.png", options.out / "chart.svg");
  if (!diagnosis.empty()) std::fprintf(stderr, "thew: %s\n", diagnosis.c_str());
  write_durably(options.out / "chart.html", chart_html(chart));
  std::vector<std::string> files = {"chart.html", "chart.csv", "chart.json", "chart.svg"};
  if (diagnosis.empty()) files.push_back("chart.png");
  tell(options, files);
  return ExitCode::kDone;
}

}  // namespace thew::tools
