// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// Numbers to and from text, in the same format under every locale, and texts for messages.

/// A text of a foreign file, made safe for one line of a terminal: control characters become \xNN,
/// and what is beyond 2,000 bytes is cut off.
std::string printable(std::string_view text);
/// "a, b, c" of names that may come from a foreign file. Names are cut off after 100 bytes; after
/// about 1,000 bytes the rest is only counted.
std::string names_text(const std::vector<std::string>& names);

/// Six significant digits; "no number" for NaN, "infinite" or "minus infinite" for infinity.
std::string number_text(double value);
/// "(0.01, 0.2, 0)"
std::string point_text(const Vec3& point);
/// The number that the whole word stands for, or nothing. A leading '+' is allowed.
std::optional<double> parse_number(std::string_view word);

/// Words between blanks.
std::vector<std::string_view> split_words(std::string_view line);

/// Throws Error(kInput) unless `file` is a regular file of at most `limit` bytes; opens nothing.
void check_readable(const std::filesystem::path& file, size_t limit);
/// Throws Error(kInput) with the file's name before `what`.
[[noreturn]] void refuse_file(const std::filesystem::path& file, const std::string& what);
/// The bytes of a file that check_readable() accepts.
std::string read_whole(const std::filesystem::path& file, size_t limit);
/// Whether `file` lies below `folder`; both canonical.
bool is_below(const std::filesystem::path& file, const std::filesystem::path& folder);

/// `; did you mean "elbow"?`, or "" if no name is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& names);

}  // namespace thew::rig
