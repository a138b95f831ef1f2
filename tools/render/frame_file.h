// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace thew::tools {

/// FOLDER/VIEW.####.png, the picture of a frame in a view.
std::filesystem::path frame_file(const std::filesystem::path& folder, const std::string& view,
                                 int frame);

struct FrameName {
  std::string view;
  int frame;
};
/// VIEW.####.png taken apart; nothing of other names.
std::optional<FrameName> read_frame_name(const std::string& name);

}  // namespace thew::tools
