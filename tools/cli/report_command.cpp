// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/printing.h"
#include "tools/cli/commands.h"
#include "tools/night/night.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& name) { return !name.empty() && name != "-"; }

void write(const fs::path& file, const std::string& text) {
  const fs::path folder = file.parent_path();
  if (!folder.empty()) create_folders(folder);
  write_durably(file, text);
}

}  // namespace

ExitCode report_command(const NightOptions& asked, const CommandOptions& options) {
  std::vector<fs::path> files;
  for (const fs::path& file : {asked.html, asked.json}) {
    if (is_file(file)) files.push_back(file);
  }
  claim(files, options.overwrite);
  Night night;
  night.name = common_folder(asked.folders).filename().string();
  night.shots = find_shots(asked.folders);
  // Before anything is written: tonight's JSON may take the place of last night's.
  if (!asked.against.empty()) compare_with(read_night(asked.against), night);
  if (is_file(asked.html)) {
    const fs::path folder = fs::absolute(asked.html).parent_path();
    write(asked.html, night_as_html(night, folder));
  }
  const nlohmann::ordered_json json = night_as_json(night);
  if (is_file(asked.json)) write(asked.json, json_text(json, 1) + "\n");
  if (options.json) {
    print_json(json);
  } else {
    print(night_as_text(night));
  }
  const int missed = asked.bounds_fail ? 0 : night.count(ShotState::kMissed);
  const int good = night.count(ShotState::kDone) + missed;
  return good == static_cast<int>(night.shots.size()) ? ExitCode::kDone : ExitCode::kDifferent;
}

}  // namespace thew::tools
