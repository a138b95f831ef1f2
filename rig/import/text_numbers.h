// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace thew::rig {

/// assimp takes as much of a word for a number as looks like one, and the rest for nothing. Throws
/// Error(kInput) with file and line for the first word of an OBJ, STL, PLY or BVH in text that
/// stands where a place, a face or a key has a number and is none. Normals and texture coordinates,
/// which nobody reads, may be anything. Private to the library.
void check_text_numbers(const std::filesystem::path& file, std::string_view bytes);

}  // namespace thew::rig
