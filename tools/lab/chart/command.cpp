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
#include "tools/lab/chart/skin_chart.h"

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
  for (const char* name : {"chart.csv", "chart.json", "chart.svg", "chart.png", "chart.html",
                           "skin.csv", "skin.svg", "skin.png"}) {
    claimed.push_back(options.out / name);
  }
  claim(claimed, options.overwrite);
  ChartAsk ask{.scene = options.input, .threads = thread_count(options.threads)};
  const auto follow = [&](const char* what, const auto& run) {
    std::unique_ptr<Progress> progress;
    ask.on_step = [&](int done, int total) {
      if (!progress) progress = std::make_unique<Progress>(style, what, total, stderr);
      progress->step(done, done);
    };
    return run(ask);
  };
  const Chart chart = follow("charting", run_chart);
  std::vector<std::string> files = {"chart.html", "chart.csv", "chart.json"};
  const auto draw = [&](const std::string& name, const std::string& svg) {
    write_durably(options.out / (name + ".svg"), svg);
    files.push_back(name + ".svg");
    const fs::path png = options.out / (name + ".png");
    const std::string diagnosis = write_picture(png, options.out / (name + ".svg"));
    if (!diagnosis.empty()) std::fprintf(stderr, "thew: %s\n", diagnosis.c_str());
    if (diagnosis.empty() && fs::exists(png)) files.push_back(name + ".png");
  };
  write_durably(options.out / "chart.csv", chart_csv(chart));
  write_durably(options.out / "chart.json", chart_json(chart));
  draw("chart", draw_cost(chart, &ChartPoint::largest_mm, "largest position error, mm"));
  write_durably(options.out / "chart.html", chart_html(chart));  // whatever becomes of the skin's
  const SkinChart skin = follow("charting the skin", run_skin_chart);
  if (!skin.settings.empty()) {
    write_durably(options.out / "skin.csv", csv_of(points_of(skin)));
    files.push_back("skin.csv");
    draw("skin", draw_cost(skin.chart, &ChartPoint::largest_mm, kSkinError));
  }
  write_durably(options.out / "chart.html", chart_html(chart, html_of(skin)));
  tell(options, files);
  return ExitCode::kDone;
}

}  // namespace thew::tools
