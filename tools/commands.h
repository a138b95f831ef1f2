// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew {

/// What the command line says, for the commands that share it.
struct CommandOptions {
  std::filesystem::path input, out;
  std::vector<std::string> overrides;  ///< --set key=value
  std::string frames;                  ///< "" for all
  int threads = 0;                     ///< 0: as many as the machine or the farm gives
  bool resume = false, dry_run = false, json = false, pictures = true;
  std::string progress = "auto";
};

/// Scene -> cache, pictures, report.
ExitCode bake_command(const CommandOptions& options);
/// Cache -> pictures, by the views of a scene, or by views of its own where none is named.
ExitCode render_command(const CommandOptions& options, const std::filesystem::path& scene);
/// `repaired`: where the mesh goes once its safe repairs are done, or "".
ExitCode inspect_command(const CommandOptions& options, const std::filesystem::path& repaired);

struct NewOptions {
  std::filesystem::path character, out;
  std::map<std::string, std::string> map;  ///< part of the arm -> body
  std::string side = "both";               ///< left | right | both
  double scale = 1.0;
  bool force = false;
};
/// Character -> a scene with the template's muscles on it.
ExitCode new_command(const NewOptions& options);

/// Set by SIGTERM and SIGINT: the frame is finished and flushed, then the job ends with 75.
bool interrupted();
void listen_for_signals();

}  // namespace thew
