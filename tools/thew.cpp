// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

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

// Where a standard stream is closed, the next file would take its number, and our messages.
void open_standard_streams() {
  int stream = 0;
  do {
    stream = ::open("/dev/null", O_RDWR);
  } while (stream >= 0 && stream <= STDERR_FILENO);
  if (stream > STDERR_FILENO) ::close(stream);
}

int run(int argc, char** argv) {
  open_standard_streams();
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

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  listen_for_signals();
  if (*bake) return static_cast<int>(bake_command(options));
  if (*render) return static_cast<int>(render_command(options, scene));
  return static_cast<int>(inspect_command(options));
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
