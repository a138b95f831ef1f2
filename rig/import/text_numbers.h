// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace thew::rig {

/// Checks the numbers of an OBJ, STL, PLY or BVH in text, because assimp reads the beginning of a
/// word that looks like a number and ignores the remainder. Throws Error(kInput) with file and line
/// for the first word that is not a number although a position, a face or a key must have one
/// there. Normals and texture coordinates are not checked, because they are not used. Private to
/// the library.
void check_text_numbers(const std::filesystem::path& file, std::string_view bytes);

}  // namespace thew::rig
