// SPDX-License-Identifier: Apache-2.0
#include "tools/render/frame_file.h"

#include <charconv>
#include <cstdio>

namespace thew::tools {

std::filesystem::path frame_file(const std::filesystem::path& folder, const std::string& view,
                                 int frame) {
  char number[16];
  std::snprintf(number, sizeof number, "%04d", frame);
  return folder / (view + "." + number + ".png");
}

std::optional<FrameName> read_frame_name(const std::string& name) {
  if (!name.ends_with(".png")) return {};
  const std::string stem = name.substr(0, name.size() - 4);
  const std::size_t dot = stem.rfind('.');
  if (dot == std::string::npos) return {};
  int frame = 0;
  const char* end = stem.data() + stem.size();
  const auto [at, error] = std::from_chars(stem.data() + dot + 1, end, frame);
  if (error != std::errc() || at != end) return {};
  return FrameName{stem.substr(0, dot), frame};
}

}  // namespace thew::tools
