// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
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
/// The paper's tables and figures, ours beside the printed ones; `cow`: a mesh to press instead.
ExitCode paper_command(const CommandOptions& options, bool quick, const std::filesystem::path& cow);
ExitCode inspect_command(const CommandOptions& options);

/// Set by SIGTERM and SIGINT: the frame is finished and flushed, then the job ends with 75.
bool interrupted();
void listen_for_signals();

}  // namespace thew
