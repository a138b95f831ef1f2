// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace thew::tools {

/// What `thew new` is told.
struct NewOptions {
  std::filesystem::path character, out;
  std::map<std::string, std::string> map;  ///< part of the arm -> body
  std::vector<std::string> skin;           ///< meshes around the arms; empty: all
  std::string side = "both";               ///< left | right | both
  std::optional<double> scale;             ///< none: as a person's humerus asks for
  bool force = false, json = false;
};
}  // namespace thew::tools
