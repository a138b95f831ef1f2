// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace thew::tools {

/// What run_program gives when a program is not there or cannot be started, as the shell does.
inline constexpr int kNotFound = 127;
inline constexpr int kNotStarted = 126;

/// Runs a program of the path by its words and waits: the exit code. What it prints goes nowhere.
int run_program(const std::vector<std::string>& words);

}  // namespace thew::tools
