// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rig/types.h"
#include "tools/compare.h"

namespace thew {

/// What the command line says, for the commands that share it.
struct CommandOptions {
  std::filesystem::path input, out;
  std::vector<std::string> overrides;  ///< --set key=value
  std::string frames;                  ///< "" for all
  int threads = 0;                     ///< 0: as many as the machine or the farm gives
  bool resume = false, dry_run = false, json = false, pictures = true;
  bool overwrite = false;  ///< also what Thew did not write; bake: completed frames, unless resume
  std::string progress = "auto";
  std::string command,
      commit = "unknown";  ///< what was called, and of which commit; for the report
};

/// Scene -> cache, pictures, report.
ExitCode bake_command(const CommandOptions& options);
/// Cache -> pictures, by the views of a scene, or by views of its own where none is named;
/// `turntable` > 0: so many of one frame, all round it.
ExitCode render_command(const CommandOptions& options, const std::filesystem::path& scene,
                        int turntable = 0);
/// Cache -> a file of another program, options.out, whose ending says which. `meshes` empty: all;
/// `basis` > 0: glTF with so many morph targets at most.
ExitCode export_command(const CommandOptions& options, const std::vector<std::string>& meshes,
                        int basis);
/// The paper's tables and figures, ours beside the printed ones; `cow`: a mesh to press instead.
ExitCode paper_command(const CommandOptions& options, bool quick, const std::filesystem::path& cow);
/// Speed against accuracy of the scene's muscles, over a table of solver settings; `stability`:
/// maps of where each integrator fails instead.
ExitCode chart_command(const CommandOptions& options, bool stability);
/// options.out is the page to be written, "" for none; bakes that differ are drawn for it where
/// they moved most. kDifferent where they differ.
ExitCode compare_command(const std::filesystem::path& expected, const std::filesystem::path& actual,
                         const CommandOptions& options, CompareOptions limits);
/// Bakes the scene as its goldens were (or as the options say) and rewrites them; says what moved.
ExitCode golden_update_command(const CommandOptions& options, const std::filesystem::path& golden);
/// Bakes the scene as its goldens were, options.overrides on top, and compares. options.out keeps
/// what was baked; without it only a bake that differs is kept.
ExitCode golden_check_command(const CommandOptions& options, const std::filesystem::path& golden,
                              const CompareOptions& limits);

/// As asked; where 0 is, what the farm gives of what the machine has.
int thread_count(int asked);

/// An empty folder under the system's temporary one, removed with all that is in it unless kept.
/// Error(kOutput).
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& what);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  bool kept_ = false;
};
/// `repaired`: where the mesh goes once its safe repairs are done, or "".
ExitCode inspect_command(const CommandOptions& options, const std::filesystem::path& repaired);

struct NewOptions {
  std::filesystem::path character, out;
  std::map<std::string, std::string> map;  ///< part of the arm -> body
  std::vector<std::string> skin;           ///< meshes around the arms; empty: all
  std::string side = "both";               ///< left | right | both
  std::optional<double> scale;             ///< none: as a person's humerus asks for
  bool force = false, json = false;
};
/// Character -> a scene with the template's muscles on it.
ExitCode new_command(const NewOptions& options);

}  // namespace thew
