// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/command.h"

#include <unistd.h>

#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "sim/scene/reader.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/lab/failure/maps.h"

namespace thew::tools {

ExitCode stability_command(const CommandOptions& options) {
  create_folders(options.out);
  const FolderLock lock(options.out);
  const auto at = [&](const char* ending) {
    return options.out / (std::string("stability") + ending);
  };
  claim({at(".html"), at(".csv"), at(".json")}, options.overwrite);
  const ProgressStyle style = parse_progress(options.progress, isatty(STDERR_FILENO) != 0);
  MapAsk ask{.scene = options.input, .threads = thread_count(options.threads)};
  std::unique_ptr<Progress> progress;
  ask.on_map = [&](int done, int total) {
    if (!progress) progress = std::make_unique<Progress>(style, "mapping", total, stderr);
    progress->step(done, done);
  };
  const std::clock_t begin = std::clock();
  const std::vector<StabilityMap> maps = run_maps(ask);
  progress.reset();
  const double minutes = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / 60.0;
  write_durably(at(".csv"), maps_csv(maps));
  write_durably(at(".json"), maps_json(maps));
  write_durably(at(".html"), maps_html(read_scene(options.input).name, maps, minutes));
  if (!options.json) return print(at(".html").string() + "\n"), ExitCode::kDone;
  nlohmann::ordered_json json = {{"files", nlohmann::ordered_json::array()}};
  for (const char* ending : {".html", ".csv", ".json"}) {
    json["files"].push_back(at(ending).string());
  }
  print_json(json);
  return ExitCode::kDone;
}

}  // namespace thew::tools
