// SPDX-License-Identifier: Apache-2.0
#include "rig/import/text_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "rig/import/assimp_scene.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

using Words = std::vector<std::string_view>;

struct TextFile {
  const std::filesystem::path& file;
  std::string_view bytes;
  int row = 0;

  [[noreturn]] void refuse(std::string_view word, const std::string& what) const {
    std::string shown(word.substr(0, 40));
    for (char& c : shown) {
      if (c < ' ' || c > '~') c = '?';
    }
    throw Error(ErrorCode::kInput, file.string() + ":" + std::to_string(row) + ": \"" + shown +
                                       "\" " + what + "; export the file again");
  }
  void need_numbers(const Words& words, size_t first) const {
    for (size_t k = first; k < words.size(); ++k) {
      const auto number = parse_number(words[k]);
      if (!number || !std::isfinite(*number)) refuse(words[k], "is not a finite number");
    }
  }
};

void for_each_line(TextFile& text, const std::function<void(const Words&)>& visit) {
  for (size_t begin = 0; begin < text.bytes.size();) {
    const size_t end = std::min(text.bytes.find('\n', begin), text.bytes.size());
    ++text.row;
    const Words words = split_words(text.bytes.substr(begin, end - begin));
    if (!words.empty()) visit(words);
    begin = end + 1;
  }
}

// Whether a word is a corner of a face: "3", "3/1", "3//2" or "3/1/2", where a negative index
// counts from the end.
bool is_corner(std::string_view word) {
  int parts = 0;
  while (true) {
    const size_t end = std::min(word.find('/'), word.size());
    const std::string_view part = word.substr(0, end);
    const auto number = parse_number(part);
    const bool whole = number && *number != 0.0 && *number == std::floor(*number) &&
                       part.find_first_not_of("-0123456789") == part.npos;
    if (!whole && !(part.empty() && parts > 0)) return false;
    if (++parts > 3) return false;
    if (end == word.size()) return true;
    word.remove_prefix(end + 1);
  }
}

void check_obj(TextFile& text) {
  std::string_view kind;  // first word of a line and of those that a backslash joins to it
  bool goes_on = false;
  for_each_line(text, [&](Words words) {
    if (!goes_on) kind = words[0];
    size_t first = goes_on ? 0 : 1;
    goes_on = words.back().ends_with('\\');
    if (goes_on) words.back().remove_suffix(1);
    if (words.back().empty()) words.pop_back();
    const auto comment = std::find_if(words.begin(), words.end(),
                                      [](std::string_view word) { return word[0] == '#'; });
    words.erase(comment, words.end());
    if (kind == "v") text.need_numbers(words, first);
    if (kind != "f") return;
    for (; first < words.size(); ++first) {
      if (!is_corner(words[first])) text.refuse(words[first], "is not a vertex of a face");
    }
  });
}

void check_stl(TextFile& text) {
  constexpr size_t kHeader = 80, kFacet = 50;
  std::uint32_t facets = 0;
  if (text.bytes.size() >= kHeader + sizeof facets) {
    std::memcpy(&facets, text.bytes.data() + kHeader, sizeof facets);
    if (text.bytes.size() == kHeader + sizeof facets + kFacet * facets) return;  // binary
  }
  if (!text.bytes.starts_with("solid")) return;
  for_each_line(text, [&](const Words& words) {
    if (words[0] == "vertex") text.need_numbers(words, 1);
  });
}

void check_ply(TextFile& text) {
  bool in_text = false, body = false;
  for_each_line(text, [&](const Words& words) {
    if (body) text.need_numbers(words, 0);
    if (!body && words.size() > 1 && words[0] == "format") in_text = words[1] == "ascii";
    if (words[0] == "end_header") body = in_text;
  });
}

void check_bvh(TextFile& text) {
  bool motion = false;
  for_each_line(text, [&](const Words& words) {
    if (motion || words[0] == "OFFSET") text.need_numbers(words, motion ? 0 : 1);
    if (words.size() == 3 && words[0] == "Frame" && words[1] == "Time:") {
      text.need_numbers(words, 2);
      motion = true;
    }
  });
}

}  // namespace

void check_text_numbers(const std::filesystem::path& file, std::string_view bytes) {
  TextFile text{file, bytes};
  const std::string ending = lower_ending(file);
  if (ending == "obj") check_obj(text);
  if (ending == "stl") check_stl(text);
  if (ending == "ply") check_ply(text);
  if (ending == "bvh") check_bvh(text);
}

}  // namespace thew::rig
