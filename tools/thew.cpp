// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/commands.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

void add_common(CLI::App& command, CommandOptions& options) {
  command.add_option("--frames", options.frames, "1-120, 1-120x2, or a list of these");
  command.add_option("--set", options.overrides, "any key of the scene: solver.volume=none")
      ->type_size(1)
      ->allow_extra_args(false);
  command.add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  command.add_option("--progress", options.progress, "auto, bar, plain, json or none");
}

void add_limits(CLI::App& command, CompareOptions& limits, double& millimetres) {
  command.add_option("--distance", millimetres, "mm that a vertex may move")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  PixelLimits& pixels = limits.limits;
  command.add_option("--threshold", pixels.threshold, "levels of 255 beyond which a pixel changed")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  command.add_option("--share", pixels.share, "of the pixels that may change")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--largest", pixels.largest, "levels by which any pixel may change")
      ->check(CLI::Range(0, 255))
      ->capture_default_str();
  command.add_option("--rmse", pixels.rmse, "levels at most; not limited unless given");
  command.add_option("--ssim", pixels.ssim, "at least; not limited unless given");
  command.add_option("--flip", pixels.flip, "mean FLIP at most; not limited unless given");
  command.add_option("--mask", limits.mask, "PNG: what is dark in it is not compared");
}

// Where a standard stream is closed, the next file would take its number, and our messages.
void open_standard_streams() {
  int stream = 0;
  do {
    stream = ::open("/dev/null", O_RDWR);
  } while (stream >= 0 && stream <= STDERR_FILENO);
  if (stream > STDERR_FILENO) ::close(stream);
}

CLI::App* add_bake(CLI::App& app, CommandOptions& options) {
  CLI::App* command = app.add_subcommand("bake", "rig -> muscles -> skin -> cache, frames, report");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the bake")->required();
  add_common(*command, options);
  command->add_flag("--resume", options.resume, "go on with what an interrupted bake left");
  command->add_flag("--dry-run", options.dry_run, "read and check all, say what would be done");
  command->add_flag("--json", options.json, "print the report");
  command->add_flag("!--no-render", options.pictures, "no pictures");
  return command;
}

CLI::App* add_render(CLI::App& app, CommandOptions& options, fs::path& scene, int& turntable) {
  CLI::App* command = app.add_subcommand("render", "frames again from a cache, no simulation");
  command->add_option("BAKE", options.input, "bake.h5")->required();
  command->add_option("--scene", scene, "scene whose views are drawn; its [render] is enough");
  command->add_option("--turntable", turntable, "pictures all round one frame, this many a view")
      ->check(CLI::Range(1, 10000));
  command->add_option("--out", options.out, "folder of the pictures")->required();
  add_common(*command, options);
  return command;
}

CLI::App* add_export(CLI::App& app, CommandOptions& options, std::vector<std::string>& meshes,
                     int& basis) {
  CLI::App* command = app.add_subcommand(
      "export", "a bake for other programs: .pc2 .mdd .obj .ply .glb .xdmf .usda .abc");
  command->add_option("BAKE", options.input, "bake.h5")->required();
  command->add_option("FILE", options.out, "format by ending; #### is the frame in a sequence")
      ->required();
  command->add_option("--mesh", meshes, "by name, once or more; all where it is left out")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("--basis", basis, ".glb: so many morph targets instead of one a frame")
      ->check(CLI::Range(1, 10000));
  command->add_option("--frames", options.frames, "1-120, 1-120x2, or a list of these");
  command->add_option("--progress", options.progress, "auto, bar, plain, json or none");
  command->add_flag("--json", options.json, "say what was written as JSON");
  return command;
}

void add_inspect(CLI::App& app, CommandOptions& options, fs::path& repaired) {
  CLI::App* command = app.add_subcommand(
      "inspect", "what a mesh, rig, scene or bake is, and what is wrong with it");
  command->add_option("FILE", options.input)->required();
  command->add_flag("--json", options.json);
  command->add_option("--frames", options.frames, "of a bake: those to check for crossings");
  command->add_option("--repair", repaired, "OUT.obj: weld, orient, fill small holes");
}

CLI::App* add_new(CLI::App& app, NewOptions& options) {
  CLI::App* command = app.add_subcommand("new", "a scene for another character");
  command->add_option("CHARACTER", options.character, "glTF, FBX or Collada")->required();
  command->add_option("--out", options.out, "the scene, SCENE.toml")->required();
  command->add_option("--template", "arm")->check(CLI::IsMember({"arm"}));
  command->add_option("--side", options.side)->check(CLI::IsMember({"left", "right", "both"}));
  command->add_option("--scale", options.scale, "times all lengths of the file")
      ->check(CLI::Range(1e-6, 1e6));
  command->add_option_function<std::vector<std::string>>(
      "--map",
      [&options](const std::vector<std::string>& pairs) {
        for (const std::string& pair : pairs) {
          const size_t middle = pair.find('=');
          if (middle == std::string::npos) throw CLI::ValidationError("--map", "give PART=BODY");
          options.map[pair.substr(0, middle)] = pair.substr(middle + 1);
        }
      },
      "humerus=BODY, also clavicle, forearm, hand, with left_ or right_ before it");
  command->add_flag("--force", options.force, "replace a scene that is there");
  return command;
}

CLI::App* add_compare(CLI::App& app, CommandOptions& options, fs::path& actual,
                      CompareOptions& limits, double& millimetres) {
  CLI::App* command = app.add_subcommand(
      "compare", "two bakes, PNGs or folders of them; ends with 0 if the same, 1 if different");
  command->add_option("EXPECTED", options.input)->required();
  command->add_option("ACTUAL", actual)->required();
  command->add_option("--frames", options.frames, "those to compare");
  command->add_option("--html", options.out, "write a page with both, difference and slider");
  command->add_flag("--json", options.json, "print all measures");
  command->add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  add_limits(*command, limits, millimetres);
  return command;
}

// What update and check have in common.
void add_golden(CLI::App& command, CommandOptions& options, fs::path& golden) {
  command.add_option("SCENE", options.input)->required();
  command.add_option("--golden", golden, "their folder; else golden/ beside the scene");
  command.add_option("--out", options.out, "keep what is baked here");
  command.add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  command.add_option("--progress", options.progress, "auto, bar, plain, json or none");
  command.add_option("--set", options.overrides, "keys of the scene that differ for the goldens")
      ->type_size(1)
      ->allow_extra_args(false);
}

CLI::App* add_update(CLI::App& goldens, CommandOptions& options, fs::path& golden) {
  CLI::App* command = goldens.add_subcommand("update", "rewrite them on purpose, say what moved");
  add_golden(*command, options, golden);
  command->add_option("--frames", options.frames, "those to keep; else as before");
  return command;
}

CLI::App* add_check(CLI::App& goldens, CommandOptions& options, fs::path& golden,
                    CompareOptions& limits, double& millimetres) {
  CLI::App* command = goldens.add_subcommand("check", "bake the scene and compare with them");
  add_golden(*command, options, golden);
  command->add_flag("--json", options.json, "print all measures");
  add_limits(*command, limits, millimetres);
  return command;
}

CLI::App* add_paper(CLI::App& app, CommandOptions& options, bool& quick, fs::path& cow) {
  CLI::App* command =
      app.add_subcommand("paper", "the paper's tables and figures, ours beside them");
  command->add_option("--out", options.out, "folder of the report")->required();
  command->add_flag("--quick", quick, "within a minute: fewer frames, repetitions and elements");
  command->add_option("--cow", cow, "a closed mesh, brought to the cow's 14,136 triangles")
      ->check(CLI::ExistingFile);
  command->add_option("--progress", options.progress, "auto, bar, plain, json or none");
  return command;
}

CLI::App* add_chart(CLI::App& app, CommandOptions& options, bool& stability) {
  CLI::App* command = app.add_subcommand("chart", "speed against accuracy of a scene's muscles");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the chart")->required();
  command->add_option("--threads", options.threads, "0: all; what is timed runs on one")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--stability", stability, "maps of where each integrator fails instead");
  command->add_option("--progress", options.progress, "auto, bar, plain, json or none");
  return command;
}

int run(int argc, char** argv) {
  open_standard_streams();
  CLI::App app{"Thew deforms the muscles and skin of animated characters."};
  app.set_version_flag("--version", "thew 0.1.0");
  app.require_subcommand(1);
  CommandOptions options;
  NewOptions new_options;
  CompareOptions limits;
  fs::path scene, repaired, actual, golden, cow;
  std::vector<std::string> meshes;
  int turntable = 0, basis = 0;
  double millimetres = 1e3 * kDistanceTolerance;
  bool quick = false, stability = false;
  CLI::App* bake = add_bake(app, options);
  CLI::App* render = add_render(app, options, scene, turntable);
  CLI::App* exporting = add_export(app, options, meshes, basis);
  add_inspect(app, options, repaired);
  CLI::App* create = add_new(app, new_options);
  CLI::App* compare = add_compare(app, options, actual, limits, millimetres);
  CLI::App* goldens = app.add_subcommand("golden", "goldens of a scene, beside it or elsewhere");
  goldens->require_subcommand(1);
  CLI::App* update = add_update(*goldens, options, golden);
  CLI::App* check = add_check(*goldens, options, golden, limits, millimetres);
  CLI::App* paper = add_paper(app, options, quick, cow);
  CLI::App* chart = add_chart(app, options, stability);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  listen_for_signals();
  if (*bake) return static_cast<int>(bake_command(options));
  if (*render) return static_cast<int>(render_command(options, scene, turntable));
  limits.distance = 1e-3 * millimetres;
  if (*compare) return static_cast<int>(compare_command(options.input, actual, options, limits));
  if (golden.empty()) golden = options.input.parent_path() / "golden";
  if (*update) return static_cast<int>(golden_update_command(options, golden));
  if (*check) return static_cast<int>(golden_check_command(options, golden, limits));
  if (*exporting) return static_cast<int>(export_command(options, meshes, basis));
  if (*paper) return static_cast<int>(paper_command(options, quick, cow));
  if (*chart) return static_cast<int>(chart_command(options, stability));
  if (*create) return static_cast<int>(new_command(new_options));
  return static_cast<int>(inspect_command(options, repaired));
}

}  // namespace
}  // namespace thew

int main(int argc, char** argv) {
  try {
    return thew::run(argc, argv);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "thew: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    std::fputs("thew: there is not enough memory; free some, then run again with --resume\n",
               stderr);
    return static_cast<int>(thew::ExitCode::kRetry);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "thew: %s; this is a defect of Thew, please report it\n", error.what());
    return static_cast<int>(thew::ExitCode::kSolver);
  }
}
