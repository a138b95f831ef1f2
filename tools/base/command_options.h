// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/base/exit_code.h"
#include "tools/base/options.h"

namespace thew::tools {

/// What the command line says, for the commands that share it.
struct CommandOptions {
  std::filesystem::path input, out;
  std::vector<std::string> overrides;  ///< --set key=value
  std::string frames;                  ///< "" for all
  int threads = 0;                     ///< 0: as many as the machine or the farm gives
  bool resume = false, dry_run = false, json = false, pictures = true;
  bool overwrite = false;   ///< also what Thew did not write; bake: completed frames, unless resume
  bool chunk = false;       ///< bake: leaves its frames as parts; render: of pictures of many
  bool bounds_fail = true;  ///< bake: a bound that is not met ends it with kDifferent
  std::filesystem::path chunks;  ///< bake: a folder of such bakes, which are joined; "" for none
  std::string progress = "auto";
  /// What was called, where, and of which commit; for the report.
  std::string command, directory, commit = "unknown";
};

/// What --progress says, on standard error.
ProgressStyle progress_style(const CommandOptions& options);

/// As asked; where 0 is, what the farm gives of what the machine has.
int thread_count(int asked);

}  // namespace thew::tools
