// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thew::tools {

// A folder of goldens is that of a small bake, so that every command reads it: bake.h5 (float32;
// its hash is that of the positions in double precision), frames/VIEW.####.png, and golden.json,
// which says how they were baked.

/// golden.json
struct GoldenRecipe {
  std::string frames;                      ///< as --frames has them
  std::vector<std::string> set;            ///< as --set has them
  std::vector<std::string> pictures = {};  ///< in frames/; what else lies there is not ours
};

/// Error(kInput) that says how goldens are made where there are none.
GoldenRecipe read_recipe(const std::filesystem::path& golden);
bool has_goldens(const std::filesystem::path& golden);

/// Error(kOutput) where a bake that is no golden is in the way, or a link; to be asked first.
void check_goldens(const std::filesystem::path& golden, bool overwrite);
/// Makes a bake (in double precision) with its pictures the goldens, in place of those that
/// golden.json lists. What else lies in the folder stays, or ends it before anything is replaced.
void keep_goldens(const std::filesystem::path& baked, const GoldenRecipe& recipe,
                  const std::filesystem::path& golden, bool overwrite);

}  // namespace thew::tools
