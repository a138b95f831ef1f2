// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thew::tools {

/// Frames as users of such tools write them: "1-120", "1-120x2" or "1-120:2" (every second one),
/// "7",
/// "-5--1", and lists of these, "1-10,15,20-40x5". Rising, each once. Error(kUsage) otherwise.
std::vector<int> parse_frames(const std::string& text);
/// The same, all of them within first..last.
std::vector<int> parse_frames(const std::string& text, int first, int last);

enum class ProgressStyle { kBar, kPlain, kJson, kOpenJd, kNone };
/// auto | bar | plain | json | openjd | none; auto is a bar on a terminal and plain lines
/// elsewhere. Error(kUsage) for other words.
ProgressStyle parse_progress(const std::string& word, bool on_terminal);

/// The words of a command line as a shell reads them.
std::string command_text(int argc, const char* const* argv);
std::string command_text(const std::vector<std::string>& words);

/// What we bring along, "arm/arm.toml" for instance: installed below the program's prefix, or in
/// the source tree it was built from. Error(kInput) where it is in neither.
std::filesystem::path own_asset(const std::string& name);

}  // namespace thew::tools
