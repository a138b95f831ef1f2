// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace thew::tools {

/// The manual page of the program `name`, as man reads it, from what the commands say of
/// themselves.
std::string man_page(const CLI::App& app, const std::string& name, const std::string& version);

/// What makes bash, zsh or fish complete the words of the command. Error(kUsage) for other shells.
std::string completion(const CLI::App& app, const std::string& shell);

}  // namespace thew::tools
