// SPDX-License-Identifier: Apache-2.0
#include "tools/base/command_options.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <thread>

#include "rig/text.h"

namespace thew::tools {

ProgressStyle progress_style(const CommandOptions& options) {
  return parse_progress(options.progress, ::isatty(STDERR_FILENO) != 0);
}

int thread_count(int asked) {
  if (asked > 0) return asked;
  const int machine = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const char* farm = std::getenv("SLURM_CPUS_PER_TASK");
  const std::optional<double> given = farm ? parse_number(farm) : std::nullopt;
  return given && *given >= 1.0 ? static_cast<int>(std::min<double>(*given, machine)) : machine;
}

}  // namespace thew::tools
