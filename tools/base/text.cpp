// SPDX-License-Identifier: Apache-2.0
#include "tools/base/text.h"

#include <algorithm>
#include <charconv>

namespace thew::tools {

std::string readable(double value, int digits) {
  char text[64];
  const auto end =
      std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits);
  std::string number(text, end.ptr);
  const std::size_t e = number.find('e');  // 1e-9, not 1e-09
  while (e != std::string::npos && number[e + 2] == '0') number.erase(e + 2, 1);
  return number;
}

std::string escape_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string frame_list(const std::vector<int>& frames, const std::string& to) {
  std::string text;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i + 1;
    while (end < frames.size() && frames[end] == frames[end - 1] + 1) ++end;
    text += (text.empty() ? "" : ", ") + std::to_string(frames[i]);
    if (end - i > 1) text += to + std::to_string(frames[end - 1]);
    i = end;
  }
  return text;
}

}  // namespace thew::tools
