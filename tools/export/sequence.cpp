// SPDX-License-Identifier: Apache-2.0
#include "tools/export/sequence.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace thew::tools {

std::filesystem::path sequence_file(const std::filesystem::path& pattern, int frame) {
  std::string name = pattern.filename().string();
  if (name.find('#') == std::string::npos) {
    name = pattern.stem().string() + ".####" + pattern.extension().string();
  }
  const std::size_t last = name.rfind('#');
  const std::size_t before = name.find_last_not_of('#', last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  const std::size_t width = last + 1 - first;
  char number[32];
  std::snprintf(number, sizeof number, "%0*d", static_cast<int>(std::min<std::size_t>(width, 20)),
                frame);
  name.replace(first, width, number);
  return pattern.parent_path() / name;
}

std::filesystem::path materials_file(const std::filesystem::path& pattern) {
  std::string name = pattern.stem().string();
  name.erase(std::remove(name.begin(), name.end(), '#'), name.end());
  while (!name.empty() && std::string("._-").find(name.back()) != std::string::npos) {
    name.pop_back();
  }
  return pattern.parent_path() / ((name.empty() ? "materials" : name) + ".mtl");
}

}  // namespace thew::tools
