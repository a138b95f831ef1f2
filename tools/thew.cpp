// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "rig/skeleton.h"
#include "rig/text.h"
#include "tools/commands.h"
#include "tools/commit.h"
#include "tools/large_stack.h"
#include "tools/options.h"
#include "tools/printing.h"
#include "tools/signals.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

constexpr const char* kProgress = "auto, bar, plain, json, openjd or none";
constexpr const char* kJson = "one JSON document on standard output, errors too";
constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 compared and different, or a bound of the scene not met; 2 usage or "
    "scene;\n3 bad input file; 4 cannot write; 5 the solver could not go on; 75 interrupted, "
    "locked or short of\nmemory or processes: run again";

// What main has to know of the command line.
struct Call {
  std::vector<std::string> words;
  std::string command;  ///< "bake", "golden update"; "" where none is known
  fs::path out;         ///< what it writes, or its folder
  bool json = false;
};

void add_common(CLI::App& command, CommandOptions& options) {
  command.add_option("--frames", options.frames, "1-120, 1-120x2, or a list of these");
  command.add_option("--set", options.overrides, "any key of the scene: solver.volume=none")
      ->type_size(1)
      ->allow_extra_args(false);
  command.add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  command.add_option("--progress", options.progress, kProgress);
}

void add_overwrite(CLI::App& command, CommandOptions& options,
                   const char* what = "replace files that Thew did not write") {
  command.add_flag("--overwrite", options.overwrite, what);
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

// Where a standard stream is closed, the next file would take its number, and our messages. What
// stands in for the output cannot be written to, so that print() finds it closed.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    if (::open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR) < 0) return;
  }
}

CLI::App* add_bake(CLI::App& app, CommandOptions& options) {
  CLI::App* command = app.add_subcommand("bake", "rig -> muscles -> skin -> cache, frames, report");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the bake")->required();
  add_common(*command, options);
  command->add_flag("--resume", options.resume, "go on with what an interrupted bake left");
  add_overwrite(*command, options,
                "bake anew (with --resume: go on), and replace files that Thew did not write");
  command->add_flag("--dry-run", options.dry_run, "read and check all, say what would be done");
  command->add_flag("--json", options.json, kJson);
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
  add_overwrite(*command, options);
  add_common(*command, options);
  command->add_flag("--json", options.json, kJson);
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
  add_overwrite(*command, options);
  command->add_option("--basis", basis, ".glb: so many morph targets instead of one a frame")
      ->check(CLI::Range(1, 10000));
  command->add_option("--frames", options.frames, "1-120, 1-120x2, or a list of these");
  command->add_option("--progress", options.progress, kProgress);
  command->add_flag("--json", options.json, kJson);
  return command;
}

void add_inspect(CLI::App& app, CommandOptions& options, fs::path& repaired) {
  CLI::App* command = app.add_subcommand(
      "inspect", "what a mesh, rig, scene or bake is, and what is wrong with it");
  command->add_option("FILE", options.input, "mesh, character, .urdf, .toml or .h5")->required();
  command->add_flag("--json", options.json, kJson);
  command->add_option("--frames", options.frames, "of a bake: those to check for crossings");
  command->add_option("--repair", repaired, "OUT.obj: weld, orient, fill small holes");
  add_overwrite(*command, options);
}

CLI::App* add_new(CLI::App& app, NewOptions& options, bool& json) {
  CLI::App* command = app.add_subcommand("new", "a scene for another character");
  command->add_option("CHARACTER", options.character, "glTF, VRM, FBX or Collada")->required();
  command->add_option("--out", options.out, "the scene, SCENE.toml")->required();
  command->add_option("--template", "what is put on it")->check(CLI::IsMember({"arm"}));
  command->add_option("--side", options.side, "whose arm")
      ->check(CLI::IsMember({"left", "right", "both"}))
      ->capture_default_str();
  command->add_option("--scale", options.scale, "times all lengths of the file; 1: as they are")
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
  command->add_option("--skin", options.skin, "a mesh around the arm, of several; else all are")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_flag("--force,--overwrite", options.force,
                    "replace a scene that is there, and files that Thew did not write");
  command->add_flag("--json", json, kJson);
  return command;
}

CLI::App* add_compare(CLI::App& app, CommandOptions& options, fs::path& actual,
                      CompareOptions& limits, double& millimetres) {
  CLI::App* command = app.add_subcommand(
      "compare", "two bakes, PNGs or folders of them; ends with 0 if the same, 1 if different");
  command->add_option("EXPECTED", options.input, "bake, PNG or folder")->required();
  command->add_option("ACTUAL", actual, "the same kind")->required();
  command->add_option("--frames", options.frames, "those to compare");
  command->add_option("--html", options.out, "write a page with both, difference and slider");
  add_overwrite(*command, options);
  command->add_flag("--json", options.json, kJson);
  command->add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  add_limits(*command, limits, millimetres);
  return command;
}

// What update and check have in common.
void add_golden(CLI::App& command, CommandOptions& options, fs::path& golden) {
  command.add_option("SCENE", options.input, "scene file, TOML")->required();
  command.add_flag("--json", options.json, kJson);
  command.add_option("--golden", golden, "their folder; else golden/ beside the scene");
  command.add_option("--out", options.out, "keep what is baked here");
  add_overwrite(command, options);
  command.add_option("--threads", options.threads, "0: all")->check(CLI::Range(0, 1024));
  command.add_option("--progress", options.progress, kProgress);
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
  add_limits(*command, limits, millimetres);
  return command;
}

CLI::App* add_paper(CLI::App& app, CommandOptions& options, bool& quick, fs::path& cow) {
  CLI::App* command =
      app.add_subcommand("paper", "the paper's tables and figures, ours beside them");
  command->add_option("--out", options.out, "folder of the report")->required();
  command->add_flag("--json", options.json, kJson);
  add_overwrite(*command, options);
  command->add_flag("--quick", quick, "within a minute: fewer frames, repetitions and elements");
  command->add_option("--cow", cow, "a closed mesh, brought to the cow's 14,136 triangles")
      ->check(CLI::ExistingFile);
  command->add_option("--progress", options.progress, kProgress);
  return command;
}

CLI::App* add_chart(CLI::App& app, CommandOptions& options, bool& stability) {
  CLI::App* command = app.add_subcommand("chart", "speed against accuracy of a scene's muscles");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the chart")->required();
  add_overwrite(*command, options);
  command->add_option("--threads", options.threads, "0: all; what is timed runs on one")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--json", options.json, kJson);
  command->add_flag("--stability", stability, "maps of where each integrator fails instead");
  command->add_option("--progress", options.progress, kProgress);
  return command;
}

std::vector<std::string> names_of(const CLI::App& command, bool options) {
  std::vector<std::string> names;
  if (!options) {
    for (const CLI::App* one : command.get_subcommands({})) names.push_back(one->get_name());
    return names;
  }
  for (const CLI::Option* one : command.get_options()) {
    for (const std::string& name : one->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// The nearest name, or the only one that the word begins.
std::string meant(const std::string& word, const std::vector<std::string>& names) {
  std::string near = nearest_name(word, names);
  if (!near.empty()) return near;
  const auto begun = [&](const std::string& name) { return name.starts_with(word); };
  if (std::count_if(names.begin(), names.end(), begun) != 1) return "";
  return *std::find_if(names.begin(), names.end(), begun);
}

// CLI11 would say first what is missing, of which a word written wrongly is often the cause.
Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  std::string name = app.get_name();
  while (command->remaining().empty() && !command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  const auto refuse = [&](const std::string& what, const std::string& near) {
    return Error(ExitCode::kUsage, what + (near.empty() ? "; " + name + " --help says what it takes"
                                                        : "; did you mean " + near + "?"));
  };
  const std::vector<std::string> unknown = command->remaining();
  if (unknown.empty() && command->get_require_subcommand_min() > 0) {
    return refuse("no command is given", "");
  }
  if (unknown.empty()) return refuse(error.what(), "");
  if (command->get_require_subcommand_min() > 0 && unknown[0][0] != '-') {
    return refuse("\"" + unknown[0] + "\" is no command of " + name,
                  meant(unknown[0], names_of(*command, false)));
  }
  const auto option = std::find_if(unknown.begin(), unknown.end(), [](const std::string& word) {
    return word.size() > 1 && word[0] == '-';
  });
  if (option == unknown.end()) return refuse("\"" + unknown[0] + "\" is a word too many", "");
  const std::string word = option->substr(0, option->find('='));
  return refuse(word + " is no option of " + name, meant(word, names_of(*command, true)));
}

std::string command_of(const CLI::App& app) {
  std::string name;
  for (const CLI::App* command = &app; !command->get_subcommands().empty();) {
    command = command->get_subcommands().front();
    name += (name.empty() ? "" : " ") + command->get_name();
  }
  return name;
}

int run(int argc, char** argv, Call& call) {
  if (std::find(call.words.begin(), call.words.end(), "") != call.words.end()) {
    throw Error(ExitCode::kUsage,
                "one of the command's words is empty; look for a variable that is not set");
  }
  CLI::App app{"Thew deforms the muscles and skin of animated characters.", "thew"};
  app.footer(kExitCodes);
  app.set_version_flag("--version", "thew 0.1.0");
  app.require_subcommand(1);
  CommandOptions options;
  app.add_flag("--json", options.json, kJson);
  options.command = command_text(argc, argv);
  options.commit = kCommit;
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
  CLI::App* create = add_new(app, new_options, options.json);
  CLI::App* compare = add_compare(app, options, actual, limits, millimetres);
  CLI::App* goldens = app.add_subcommand("golden", "goldens of a scene, beside it or elsewhere");
  goldens->require_subcommand(1);
  goldens->add_flag("--json", options.json, kJson);
  CLI::App* update = add_update(*goldens, options, golden);
  CLI::App* check = add_check(*goldens, options, golden, limits, millimetres);
  CLI::App* paper = add_paper(app, options, quick, cow);
  CLI::App* chart = add_chart(app, options, stability);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    std::ostringstream text;
    app.exit(asked, text, text);
    print(text.str());
    return 0;
  } catch (const CLI::ParseError& error) {
    throw usage_error(app, error);
  }
  call.command = command_of(app);
  call.json = new_options.json = options.json;
  call.out = *create ? new_options.out : options.out;
  if (options.json && options.progress == "openjd") {
    throw Error(ExitCode::kUsage,
                "--progress openjd writes to standard output, where --json is to be alone; "
                "leave one of them out");
  }
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

// What it means that the system refuses something.
Error explained(const std::error_code& cause, const std::string& place, ExitCode otherwise) {
  const int number = cause.value();
  const std::string what = place + cause.message();
  if (number == EAGAIN || number == ENOMEM || number == EMFILE || number == ENFILE) {
    return {ExitCode::kRetry,
            what + "; allow more processes, open files or memory (ulimit -a) and run again"};
  }
  if (number == ENOSPC || number == EDQUOT || number == EROFS) {
    return {ExitCode::kOutput, what + "; free some space or write elsewhere"};
  }
  return {otherwise, what + "; check the path and its permissions"};
}

bool is_at_or_below(const fs::path& path, const fs::path& folder) {
  return !folder.empty() && (path == folder || is_below(path, folder));
}

// The exception at hand as an Error.
Error explained(const Call& call) {
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const fs::filesystem_error& error) {
    const bool ours = is_at_or_below(error.path1(), call.out);
    return explained(error.code(), error.path1().string() + ": ",
                     ours ? ExitCode::kOutput : ExitCode::kInput);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::resource_unavailable_try_again) {
      return explained(error.code(), "a thread cannot be started: ", ExitCode::kRetry);
    }
    return {ExitCode::kSolver,
            std::string(error.what()) + "; this is a defect of Thew, please report it"};
  } catch (const std::bad_alloc&) {
    return {ExitCode::kRetry, "there is not enough memory; free some and run again"};
  } catch (const std::exception& error) {
    return {ExitCode::kSolver,
            std::string(error.what()) + "; this is a defect of Thew, please report it"};
  }
}

// One message for people and, where it was asked for, one document for programs.
int fail(const Error& error, const Call& call) {
  std::string message = error.what();
  if (call.command == "bake" && message.ends_with("run again")) message += " with --resume";
  std::fprintf(stderr, "thew: %s\n", printable(message).c_str());
  try {
    if (call.json) print_json(error_as_json(error.code(), split_error(message, call.words)));
  } catch (const Error&) {  // the message has been given
  }
  return static_cast<int>(error.code());
}

int run_and_explain(int argc, char** argv) {
  open_standard_streams();
  listen_for_signals();
  Call call;
  call.words.assign(argv, argv + argc);
  const auto end = std::find(call.words.begin(), call.words.end(), "--");
  call.json = std::find(call.words.begin(), end, "--json") != end;
  try {
    return run(argc, argv, call);
  } catch (...) {
    return fail(explained(call), call);
  }
}

}  // namespace
}  // namespace thew

static int run_guarded(int argc, char** argv) {
  try {
    return thew::run_and_explain(argc, argv);
  } catch (const std::bad_alloc&) {  // not even for a message
    std::fputs("thew: there is not enough memory; free some and run again\n", stderr);
    return static_cast<int>(thew::ExitCode::kRetry);
  }
}

int main(int argc, char** argv) {
  return thew::on_large_stack([&] { return run_guarded(argc, argv); });
}
