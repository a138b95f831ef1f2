// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tools/commands.h"

namespace thew {
namespace {

void add_common(CLI::App& command, CommandOptions& options) {
  command.add_option("--frames", options.frames, "1-120, 1-120x2, or a list of these");
  command.add_option("--set", options.overrides, "any key of the scene: solver.volume=none")
      ->type_size(1)
      ->allow_extra_args(false);
  command.add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  command.add_option("--progress", options.progress, "auto, bar, plain, json or none");
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

int run(int argc, char** argv) {
  CLI::App app{"Thew deforms the muscles and skin of animated characters."};
  app.set_version_flag("--version", "thew 0.1.0");
  app.require_subcommand(1);
  CommandOptions options;
  std::filesystem::path scene;

  CLI::App* bake = app.add_subcommand("bake", "rig -> muscles -> skin -> cache, frames, report");
  bake->add_option("SCENE", options.input, "scene file, TOML")->required();
  bake->add_option("--out", options.out, "folder of the bake")->required();
  add_common(*bake, options);
  bake->add_flag("--resume", options.resume, "go on with what an interrupted bake left");
  bake->add_flag("--dry-run", options.dry_run, "read and check all, say what would be done");
  bake->add_flag("--json", options.json, "print the report");
  bake->add_flag("!--no-render", options.pictures, "no pictures");

  CLI::App* render = app.add_subcommand("render", "frames again from a cache, no simulation");
  render->add_option("BAKE", options.input, "bake.h5")->required();
  render->add_option("--scene", scene, "scene whose views are drawn");
  render->add_option("--out", options.out, "folder of the pictures")->required();
  add_common(*render, options);

  CLI::App* inspect = app.add_subcommand(
      "inspect", "what a mesh, rig, scene or bake is, and what is wrong with it");
  inspect->add_option("FILE", options.input)->required();
  inspect->add_flag("--json", options.json);
  std::filesystem::path repaired;
  inspect->add_option("--repair", repaired, "OUT.obj: weld, orient, fill small holes");

  NewOptions new_options;
  CLI::App* create = add_new(app, new_options);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  listen_for_signals();
  if (*bake) return static_cast<int>(bake_command(options));
  if (*render) return static_cast<int>(render_command(options, scene));
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
