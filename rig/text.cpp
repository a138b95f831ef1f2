// SPDX-License-Identifier: Apache-2.0
#include "rig/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "rig/skeleton.h"

namespace thew::rig {

std::string printable(std::string_view text) {
  constexpr size_t kMost = 2000;  // bytes
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (const char c : text.substr(0, kMost)) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code != 0x7f) {
      out += c;
    } else {
      out += std::string("\\x") + kDigits[code >> 4] + kDigits[code & 15];
    }
  }
  return text.size() > kMost ? out + " ..." : out;
}

std::string names_text(const std::vector<std::string>& names) {
  constexpr size_t kLongestName = 100, kLongest = 1000;  // bytes
  std::string text;
  for (size_t i = 0; i < names.size(); ++i) {
    if (text.size() > kLongest) return text + ", " + std::to_string(names.size() - i) + " more";
    const bool is_long = names[i].size() > kLongestName;
    text += (i == 0 ? "" : ", ") + printable(names[i].substr(0, kLongestName));
    if (is_long) text += " ...";
  }
  return text;
}

std::string number_text(double value) {
  if (std::isnan(value)) return "no number";
  if (std::isinf(value)) return value > 0.0 ? "infinite" : "minus infinite";
  char buffer[32];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value + 0.0, std::chars_format::general, 6);
  return std::string(buffer, end.ptr);
}

std::string point_text(const Vec3& p) {
  return "(" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ")";
}

std::optional<double> parse_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> split_words(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\n";
  std::vector<std::string_view> words;
  for (size_t begin = line.find_first_not_of(kBlanks); begin != line.npos;) {
    const size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

void check_readable(const std::filesystem::path& file, size_t limit) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::none) {
    refuse_file(file, "cannot be read: " + error.message() + "; check its permissions");
  }
  if (!std::filesystem::exists(status)) {
    refuse_file(file, "there is no such file; check the path");
  }
  if (!std::filesystem::is_regular_file(status)) {
    refuse_file(file, "is not a regular file; name a file");
  }
  if (std::filesystem::file_size(file, error) > limit) {
    refuse_file(file, "is larger than the limit of " + std::to_string(limit >> 20) +
                          " MiB; reduce or split it");
  }
}

void refuse_file(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorCode::kInput, file.string() + ": " + what);
}

std::string read_whole(const std::filesystem::path& file, size_t limit) {
  check_readable(file, limit);
  std::error_code error;
  std::string bytes(std::filesystem::file_size(file, error), '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    refuse_file(file, "cannot be read; check its permissions");
  }
  return bytes;
}

bool is_below(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return end == folder.end() && rest != file.end();
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& names) {
  const std::string near = nearest_name(word, names);
  return near.empty() ? "" : "; did you mean \"" + near + "\"?";
}

}  // namespace thew::rig
