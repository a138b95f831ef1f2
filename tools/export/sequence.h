// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace thew::tools {

/// The file of a frame: the last run of # in the name becomes its number, as long as the run at
/// least (-2 as #### is -002); a name without # gets .#### before its ending.
std::filesystem::path sequence_file(const std::filesystem::path& pattern, int frame);

/// The file of materials beside a sequence of OBJ: its name without the number.
std::filesystem::path materials_file(const std::filesystem::path& pattern);

}  // namespace thew::tools
