// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace thew::tools {

/// A program that runs beside this one; it gets SIGTERM where this one is killed.
struct Process {
  pid_t id = -1;
};
/// How a process ended, and what it took.
struct Ended {
  int code = 0;  ///< exit code; 128 + n where signal n ended it, as shells say it
  double memory_mib = 0.0;
};

/// Starts it; all that it prints is added to `log`. Error(kOutput) where that cannot be written,
/// Error(kRetry) where there is no room for a process.
Process start(const std::vector<std::string>& words, const std::filesystem::path& log);
/// Nothing while it runs.
std::optional<Ended> look_at(const Process& process);
/// Waits for it, and passes a signal on that asks this program to end.
Ended wait_for(const Process& process);

}  // namespace thew::tools
