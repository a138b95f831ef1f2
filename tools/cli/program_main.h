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

// Options that several commands have.
void add_overwrite(CLI::App& command, CommandOptions& options,
                   const char* what = "replace files that Thew did not write");
void add_json(CLI::App& command, CommandOptions& options);
void add_progress(CLI::App& command, CommandOptions& options);
void add_threads(CLI::App& command, CommandOptions& options, const char* what = "0: all");
/// An option that takes one value each time it is given.
CLI::Option* add_option_repeated(CLI::App& command, const char* name,
                                 std::vector<std::string>& values, const char* what);

/// What the report of an error needs to know of the call.
struct Call {
  std::vector<std::string> words;
  std::string command;        ///< "bake", "golden update"; "" where none is known
  std::filesystem::path out;  ///< the file that it writes, or the folder
  bool json = false;
};

/// What sets one program apart from the other.
struct ProgramParts {
  std::string commit;  ///< of the sources it was built from
  /// Runs first, before signals are handled; may replace the process by another program.
  std::function<void(const Call& call, char** argv)> begin = [](const Call&, char**) {};
  /// Adds the commands and their options.
  std::function<void(CLI::App& app, CommandOptions& options)> declare;
  /// Runs the command that was called. Where it writes elsewhere than to options.out, it puts that
  /// place into call.out first.
  std::function<ExitCode(CommandOptions& options, Call& call)> run;
};

/// The whole of a main: standard streams, signals, stack, command line, and one message for an
/// error, with --json as a document as well. Returns the exit code.
int program_main(int argc, char** argv, const ProgramParts& parts);

}  // namespace thew::tools
