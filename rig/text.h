// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// Numbers to and from text, the same under every locale.

/// For one line on a terminal: what a foreign file calls its parts may hold anything. Control
/// characters as \xNN, and no more than the first of it.
std::string printable(std::string_view text);
/// "a, b, c" of names that may be a foreign file's: the begin of a long name, and how many more
/// there are than fit a line.
std::string names_text(const std::vector<std::string>& names);

/// Six significant digits; "no number", "infinite".
std::string number_text(double value);
/// "(0.01, 0.2, 0)"
std::string point_text(const Vec3& point);
/// The whole word as a number; a leading '+' is allowed, anything left over is not.
std::optional<double> parse_number(std::string_view word);

/// Words between blanks.
std::vector<std::string_view> split_words(std::string_view line);

/// Throws Error(kInput) unless `file` is a regular file of at most `limit` bytes; opens nothing.
void check_readable(const std::filesystem::path& file, size_t limit);
/// check_readable, and the file's bytes.
std::string read_whole(const std::filesystem::path& file, size_t limit);
/// Whether `file` lies below `folder`; both canonical.
bool is_below(const std::filesystem::path& file, const std::filesystem::path& folder);

/// `; did you mean "elbow"?`, or "" if no name is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& names);

}  // namespace thew::rig
