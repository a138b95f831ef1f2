// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rig/clip.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFileLimit = size_t{64} << 20;  // bytes; bounds the memory of a read

using Words = std::vector<std::string_view>;

// Reads a text line by line and names the present line in messages.
struct Lines {
  std::string file;
  std::string text;
  size_t at = 0;
  int row = 0;

  bool next(std::string_view& line) {
    if (at >= text.size()) return false;
    const size_t end = std::min(text.find('\n', at), text.size());
    line = std::string_view(text).substr(at, end - at);
    if (line.ends_with('\r')) line.remove_suffix(1);
    at = end + 1;
    ++row;
    return true;
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::kInput, file + ":" + std::to_string(std::max(row, 1)) + ": " + what);
  }
};

Lines open_lines(const fs::path& file) { return {file.string(), read_whole(file, kFileLimit)}; }

std::string_view trim(std::string_view word) {
  while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
  while (!word.empty() && (word.back() == ' ' || word.back() == '\t')) word.remove_suffix(1);
  return word;
}

Words split_commas(std::string_view line) {
  Words words;
  for (size_t begin = 0; begin <= line.size();) {
    const size_t end = std::min(line.find(',', begin), line.size());
    words.push_back(trim(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return words;
}

// For each column of the file, the column of the clip that it fills (-1: none), and the factor to
// rad or m.
struct Columns {
  std::vector<int> target;
  std::vector<double> factor;
};

Columns map_columns(const Lines& lines, const Words& labels, const ColumnMap& map, Clip& clip) {
  if (labels.empty() || labels[0] != "time") {
    lines.refuse("the first column is \"" + std::string(labels.empty() ? "" : labels[0]) +
                 "\", not \"time\"; name it so (columns of a CSV are parted by commas)");
  }
  const std::vector<std::string> names(labels.begin() + 1, labels.end());
  for (const auto& [column, joint] : map) {
    if (std::find(names.begin(), names.end(), column) != names.end()) continue;
    lines.refuse("there is no column \"" + column + "\" to map" + did_you_mean(column, names) +
                 "; correct the column map");
  }
  Columns columns{{-1}, {1.0}};
  for (size_t i = 0; i < names.size(); ++i) {
    if (std::find(names.begin(), names.begin() + static_cast<long>(i), names[i]) !=
        names.begin() + static_cast<long>(i)) {
      lines.refuse("column \"" + names[i] + "\" appears twice; rename one");
    }
    const auto mapped = map.find(names[i]);
    if (mapped == map.end()) {
      lines.refuse("column \"" + names[i] +
                   "\" is mapped to no joint; map it, to \"\" if it is to be ignored");
    }
    const std::string& joint = mapped->second;
    if (std::find(clip.joints.begin(), clip.joints.end(), joint) != clip.joints.end()) {
      lines.refuse("two columns are mapped to joint \"" + joint + "\"; map one to \"\"");
    }
    columns.target.push_back(joint.empty() ? -1 : static_cast<int>(clip.joints.size()));
    columns.factor.push_back(1.0);
    if (!joint.empty()) clip.joints.push_back(joint);
  }
  return columns;
}

void read_row(const Lines& lines, const Words& words, const Columns& columns, Clip& clip) {
  if (words.size() != columns.target.size()) {
    lines.refuse("the row has " + std::to_string(words.size()) + " values, the header " +
                 std::to_string(columns.target.size()) + " columns; complete the row");
  }
  std::vector<double> row(clip.joints.size());
  for (size_t i = 0; i < words.size(); ++i) {
    const auto number = parse_number(words[i]);
    if (!number || !std::isfinite(*number)) {
      lines.refuse("column " + std::to_string(i + 1) + ": \"" + std::string(words[i]) +
                   "\" is not a finite number; correct it");
    }
    if (i == 0 && !clip.times.empty() && *number <= clip.times.back()) {
      lines.refuse("time " + number_text(*number) + " is not after the row before; sort the rows");
    }
    if (i == 0) clip.times.push_back(*number);
    if (columns.target[i] >= 0) row[columns.target[i]] = *number * columns.factor[i];
  }
  clip.rows.push_back(lines.row);
  clip.values.push_back(std::move(row));
}

template <typename Split>
void read_rows(Lines& lines, const Columns& columns, Split split, Clip& clip) {
  clip.file = lines.file;
  std::string_view line;
  while (lines.next(line)) {
    if (!trim(line).empty()) read_row(lines, split(line), columns, clip);
  }
  if (clip.times.empty()) lines.refuse("the table has no rows; export the motion again");
}

// The lines `name=value` of the header, up to the line endheader.
struct MotHeader {
  int rows = -1, columns = -1;  // -1: not stated
  bool in_degrees = false;
};

int parse_count(const Lines& lines, std::string_view text) {
  const auto number = parse_number(text);
  if (!number || *number < 0 || *number > 1e9 || *number != std::floor(*number)) {
    lines.refuse("\"" + std::string(text) + "\" is not a count; correct the header");
  }
  return static_cast<int>(*number);
}

MotHeader read_mot_header(Lines& lines) {
  MotHeader header;
  bool has_unit = false;
  std::string_view line;
  while (lines.next(line)) {
    if (trim(line) == "endheader") {
      if (has_unit) return header;
      lines.refuse("the header has no inDegrees line; add inDegrees=yes or inDegrees=no");
    }
    const size_t equals = line.find('=');
    if (equals == line.npos) continue;
    const std::string_view name = trim(line.substr(0, equals)),
                           value = trim(line.substr(equals + 1));
    if (name == "nRows") header.rows = parse_count(lines, value);
    if (name == "nColumns") header.columns = parse_count(lines, value);
    if (name != "inDegrees") continue;
    if (value != "yes" && value != "no") {
      lines.refuse("inDegrees is \"" + std::string(value) + "\"; write yes or no");
    }
    has_unit = true;
    header.in_degrees = value == "yes";
  }
  lines.refuse("the file has no endheader line; is it an OpenSim .mot or .sto?");
}

}  // namespace

Clip read_mot(const fs::path& file, const ColumnMap& map) {
  Lines lines = open_lines(file);
  const MotHeader header = read_mot_header(lines);
  std::string_view line;
  if (!lines.next(line)) lines.refuse("the column labels are missing; export the motion again");
  const Words labels = split_words(line);
  if (header.columns >= 0 && header.columns != static_cast<int>(labels.size())) {
    lines.refuse(std::to_string(labels.size()) + " column labels, but nColumns=" +
                 std::to_string(header.columns) + "; correct the header");
  }
  Clip clip;
  clip.angles_only = header.in_degrees;
  Columns columns = map_columns(lines, labels, map, clip);
  if (header.in_degrees) std::fill(columns.factor.begin() + 1, columns.factor.end(), kDegree);
  read_rows(lines, columns, split_words, clip);
  if (header.rows >= 0 && header.rows != static_cast<int>(clip.times.size())) {
    lines.refuse(std::to_string(clip.times.size()) + " rows, but nRows=" +
                 std::to_string(header.rows) + "; the file is cut short or its header is wrong");
  }
  return clip;
}

Clip read_csv(const fs::path& file, const ColumnMap& map) {
  Lines lines = open_lines(file);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write it
  if (lines.text.starts_with(kByteOrderMark)) lines.at = kByteOrderMark.size();
  std::string_view line;
  if (!lines.next(line)) lines.refuse("the file is empty; its first row must name the columns");
  const Words labels = split_commas(line);
  Clip clip;
  Columns columns = map_columns(lines, labels, map, clip);
  for (size_t i = 1; i < labels.size(); ++i) {
    if (labels[i].ends_with("_deg")) columns.factor[i] = kDegree;
  }
  read_rows(lines, columns, split_commas, clip);
  return clip;
}

}  // namespace thew::rig
