// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "rig/types.h"
#include "tools/base/command_options.h"
#include "tools/compare/compare.h"
#include "tools/fit/new_options.h"

namespace thew::tools {

/// Scene -> cache, pictures, report.
ExitCode bake_command(const CommandOptions& options);
/// Cache -> pictures, by the views of a scene, or by views of its own where none is named;
/// `turntable` > 0: so many of one frame, all round it.
ExitCode render_command(const CommandOptions& options, const std::filesystem::path& scene,
                        int turntable = 0);
/// What an export is to be: onto which character's file the skin is put back, and what it holds.
struct ExportChoice {
  std::filesystem::path character;  ///< "": the bake's, where it is found; "none": onto none
  bool correctives = false;
  bool quantized = false;  ///< glTF of the bake's meshes: displacements as whole steps
  bool fields = false;     ///< USD, Alembic: values by node and frame that follow from the bake
};
/// Cache -> a file of another program, options.out, whose ending says which. `meshes` empty: all;
/// `basis` > 0: glTF with so many morph targets at most.
ExitCode export_command(const CommandOptions& options, const std::vector<std::string>& meshes,
                        int basis, const ExportChoice& onto = {});
/// The same; returns what the command prints with --json.
nlohmann::ordered_json export_bake(const CommandOptions& options,
                                   const std::vector<std::string>& meshes, int basis,
                                   const ExportChoice& onto);
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

/// `repaired`: where the mesh goes once its safe repairs are done, or "".
ExitCode inspect_command(const CommandOptions& options, const std::filesystem::path& repaired,
                         const std::filesystem::path& maps);

/// RANGES.toml, options.input -> poses of its scene's skin, options.out, whose ending says how.
ExitCode poses_command(const CommandOptions& options);

/// What `thew report` is asked for.
struct NightOptions {
  std::vector<std::filesystem::path> folders;  ///< bakes, or folders of bakes
  std::filesystem::path html, json, against;   ///< "" for none; json "-": none, see options.json
  bool bounds_fail = true;                     ///< a missed bound is kDifferent
};
/// Many bakes -> a page, JSON, lines of text or, with options.json, that on standard output.
/// kDifferent where one misses a bound, unless bounds_fail is false, failed or is not done.
ExitCode report_command(const NightOptions& night, const CommandOptions& options);

/// Whose jobs `thew farm` makes: one of the first three.
struct FarmChoice {
  std::filesystem::path slurm, openjd;  ///< folders of what is to be submitted
  bool local = false, submit = false;
};
/// JOBS.toml, options.input -> tasks of an engine, or run here; bakes go to options.out, or where
/// the file says.
ExitCode farm_command(const CommandOptions& options, const FarmChoice& choice);

/// Character -> a scene with the template's muscles on it.
ExitCode new_command(const NewOptions& options);
/// The same; returns what the command prints with --json. `on_warning` is told each as it is found.
nlohmann::ordered_json new_scene(const NewOptions& options,
                                 const std::function<void(const std::string&)>& on_warning);

}  // namespace thew::tools
