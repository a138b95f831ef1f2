// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/base/command_options.h"

namespace thew::tools {

inline constexpr const char* kProgressWords = "auto, bar, plain, json, openjd or none";
inline constexpr const char* kJsonFlag = "one JSON document on standard output, errors too";

void add_overwrite(CLI::App& command, CommandOptions& options,
                   const char* what = "replace files that Thew did not write");

/// What an explanation of an error needs to know of the call.
struct Call {
  std::vector<std::string> words;
  std::string command;        ///< "bake", "golden update"; "" where none is known
  std::filesystem::path out;  ///< what it writes, or its folder
  bool json = false;
};

/// What sets one program apart from the other.
struct ProgramParts {
  std::string commit;  ///< that it was built of
  /// Before all else, signals too; may become another program.
  std::function<void(const Call& call, char** argv)> begin = [](const Call&, char**) {};
  /// Adds the commands.
  std::function<void(CLI::App& app, CommandOptions& options)> declare;
  /// Runs the command that was called; says in `call` where it writes before it does.
  std::function<ExitCode(CommandOptions& options, Call& call)> run;
};

/// The whole of a main: streams, signals, stack, command line, and one message for what went wrong,
/// as JSON too where that was asked for. The exit code.
int program_main(int argc, char** argv, const ProgramParts& parts);

}  // namespace thew::tools
