// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "tools/base/command_options.h"

namespace thew::tools {

struct Inspection {
  std::string text;   ///< for people, or JSON
  bool sound = true;  ///< false: something is wrong with it, and the text says what
};

/// What a file is and what is wrong with it: a mesh (by assimp's endings), a rig (.urdf), a scene
/// (.toml) or a bake (.h5; `frames` are those checked for crossings, "" for all). Throws Error
/// where it cannot be read at all.
Inspection inspect(const std::filesystem::path& file, bool as_json, const std::string& frames = "");

/// Draws the maps of a scene into a folder, and lists them.
Inspection inspect_maps(const std::filesystem::path& file, const std::filesystem::path& folder,
                        const CommandOptions& options);

/// The reference of all keys of a scene: Markdown, or JSON.
std::string inspect_keys(bool as_json);

}  // namespace thew::tools
