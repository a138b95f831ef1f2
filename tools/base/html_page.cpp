// SPDX-License-Identifier: Apache-2.0
#include "tools/base/html_page.h"

#include <algorithm>

namespace thew::tools {

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t some = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < some ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= some ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string html_page(const std::string& title, const std::string& style, const std::string& main,
                      const std::string& script) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + "</title>\n<style>" + kPageCss + style + "</style></head>\n<body><main>\n" + main +
         "</main>" + (script.empty() ? "" : "<script>" + script + "</script>") + "</body></html>\n";
}

std::string html_figure(const std::string& inside, const std::string& caption) {
  if (inside.empty()) return "";
  return "<figure>\n" + inside + "<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string html_png(const std::string& attributes, const std::string& png) {
  return "<img " + attributes + " src=\"data:image/png;base64," + base64(png) + "\">\n";
}

}  // namespace thew::tools
