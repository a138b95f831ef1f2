// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thew::tools {

/// A shot of a character in a setting, as JOBS.toml lists them. README.md has the keys.
struct ShotBake {
  std::string name;  ///< "walk/hero/fine": its folder below `out` as well
  std::string shot;
  std::filesystem::path scene, folder;  ///< absolute
  std::vector<std::string> overrides;   ///< --set key=value
  std::vector<int> frames;              ///< to be written
  int simulated = 0;                    ///< frames of the scene up to the last of these
  bool stands_alone = false;            ///< each frame by itself
  bool has_views = false;
  std::string costs_as;  ///< scene, character and setting, whatever the shot
};

struct Jobs {
  std::filesystem::path file, out;  ///< absolute; `out` is where the bakes go
  int threads = 1;                  ///< of a task
  int chunk = 0, pictures = 0;      ///< frames of a task; 0: all of a bake
  int pilot = 4;                    ///< frames
  std::vector<std::string> exports;
  std::vector<ShotBake> bakes;  ///< shots slowest, settings fastest
};

/// Reads the file and all scenes that it names. `out` empty: as the file says. Error(kUsage) with
/// file and line.
Jobs read_jobs(const std::filesystem::path& file, const std::filesystem::path& out = {});

}  // namespace thew::tools
