// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "tools/base/commit.h"
#include "tools/base/printing.h"
#include "tools/cli/commands.h"
#include "tools/cli/inspect_command.h"
#include "tools/cli/program_main.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFrames = "1-120, 1-120x2, or a list of these";

// What bake and render have in common.
void add_common(CLI::App& command, CommandOptions& options) {
  command.add_option("--frames", options.frames, kFrames);
  add_option_repeated(command, "--set", options.overrides,
                      "any key of the scene: solver.volume=none");
  add_threads(command, options);
  add_progress(command, options);
}

void add_limits(CLI::App& command, CompareOptions& compare, double& millimetres) {
  command.add_option("--distance", millimetres, "mm that a vertex may move")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  PixelLimits& pixels = compare.limits;
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
  command.add_option("--mask", compare.mask, "PNG: what is dark in it is not compared");
}

CLI::App* add_bake(CLI::App& app, CommandOptions& options) {
  CLI::App* command = app.add_subcommand("bake", "rig -> muscles -> skin -> cache, frames, report");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the bake")->required();
  add_common(*command, options);
  command->add_flag("--resume", options.resume, "go on with what an interrupted bake left");
  add_overwrite(*command, options,
                "bake anew (with --resume: go on), and replace files that Thew did not write");
  CLI::Option* chunk = command->add_flag(
      "--chunk", options.chunk, "leave the frames as parts, for --join; no pictures, no report");
  command
      ->add_option("--join", options.chunks, "FOLDER of --chunk bakes: their frames, not simulated")
      ->excludes(chunk);
  command->add_flag("--dry-run", options.dry_run, "read and check all, say what would be done");
  add_json(*command, options);
  command->add_flag("!--no-render", options.pictures, "no pictures");
  command
      ->add_option_function<std::string>(
          "--bounds", [&options](const std::string& word) { options.bounds_fail = word == "fail"; },
          "fail, the default: a bound of the scene that is not met ends it with 1; warn: it says "
          "so")
      ->check(CLI::IsMember({"fail", "warn"}));
  return command;
}

CLI::App* add_render(CLI::App& app, CommandOptions& options, fs::path& scene, int& turntable) {
  CLI::App* command = app.add_subcommand("render", "frames again from a cache, no simulation");
  command->add_option("BAKE", options.input, "bake.h5")->required();
  command->add_option("--scene", scene, "scene whose views are drawn; [render] alone is enough");
  command->add_option("--turntable", turntable, "pictures all round one frame, this many a view")
      ->check(CLI::Range(1, 10000));
  command->add_option("--out", options.out, "folder of the pictures")->required();
  command->add_flag("--chunk", options.chunk,
                    "others draw other frames into the folder: leave their pictures, no movie");
  add_overwrite(*command, options);
  add_common(*command, options);
  add_json(*command, options);
  return command;
}

CLI::App* add_export(CLI::App& app, CommandOptions& options, std::vector<std::string>& meshes,
                     int& basis, ExportChoice& onto) {
  CLI::App* command = app.add_subcommand(
      "export", "a bake for other programs: .pc2 .mdd .obj .ply .glb .xdmf .usda .usdc .usdz .abc");
  command->add_option("BAKE", options.input, "bake.h5")->required();
  command->add_option("FILE", options.out, "format by ending; #### is the frame in a sequence")
      ->required();
  add_option_repeated(*command, "--mesh", meshes,
                      "by name, once or more; all where it is left out");
  add_overwrite(*command, options);
  command->add_option("--basis", basis, ".glb: so many morph targets instead of one a frame")
      ->check(CLI::Range(1, 10000));
  command->add_option("--onto", onto.character,
                      ".glb: the character's glTF or VRM, which comes back with its skin as baked; "
                      ".usd*, .abc, .obj: whose texture coordinates and materials the skin has, or "
                      "an OBJ of the skin at rest, whose polygons and order too; .pc2, .mdd: in "
                      "whose order; "
                      "where it is left out, the bake's, if it is found; none: the bake alone");
  command->add_flag("--correctives", onto.correctives,
                    "skeleton and weights are kept; morph targets hold what muscles add");
  command->add_flag("--quantized", onto.quantized,
                    ".glb: displacements in whole steps, half as large; says what that costs");
  command->add_flag("--fields", onto.fields,
                    ".usd*, .abc: fibre directions of muscles and stretch of the skin, by node");
  command->add_option("--frames", options.frames, kFrames);
  add_progress(*command, options);
  add_json(*command, options);
  return command;
}

CLI::App* add_inspect(CLI::App& app, CommandOptions& options, fs::path& repaired, fs::path& maps,
                      bool& keys) {
  CLI::App* command = app.add_subcommand(
      "inspect",
      "what a mesh, character, motion, rig, scene or bake is, and what is wrong with it");
  CLI::Option* file =
      command->add_option("FILE", options.input, "mesh, character, motion, .urdf, .toml or .h5");
  file->required();
  command
      ->add_flag_callback(
          "--keys",
          [&keys, file] {
            keys = true;
            file->required(false);
          },
          "no file, but the reference of all keys of a scene, as Markdown")
      ->excludes(file);
  add_json(*command, options);
  command->add_option("--frames", options.frames, "of a bake: those to check for crossings");
  command->add_option("--repair", repaired, "OUT.obj: weld, orient, fill small holes");
  command->add_option("--maps", maps, "FOLDER: of a scene, each map drawn on its mesh, as PNG");
  add_overwrite(*command, options);
  return command;
}

CLI::App* add_new(CLI::App& app, NewOptions& options, CommandOptions& common) {
  CLI::App* command = app.add_subcommand("new", "a scene for another character");
  command->add_option("CHARACTER", options.character, "glTF, VRM, FBX or Collada")->required();
  command->add_option("--out", options.out, "the scene, SCENE.toml")->required();
  command->add_option("--template", "what is put on it")->check(CLI::IsMember({"arm"}));
  command->add_option("--side", options.side, "whose arm")
      ->check(CLI::IsMember({"left", "right", "both"}))
      ->capture_default_str();
  command->add_option("--scale", options.scale, "times all lengths of the file; 1: as they are")
      ->check(CLI::Range(1e-6, 1e6));
  const auto map = [&options](const std::vector<std::string>& pairs) {
    for (const std::string& pair : pairs) {
      const size_t middle = pair.find('=');
      if (middle == std::string::npos) throw CLI::ValidationError("--map", "give PART=BODY");
      options.map[pair.substr(0, middle)] = pair.substr(middle + 1);
    }
  };
  command->add_option_function<std::vector<std::string>>(
      "--map", map, "humerus=BODY, also clavicle, forearm, hand, with left_ or right_ before it");
  add_option_repeated(*command, "--skin", options.skin,
                      "a mesh around the arm, of several; else all are");
  command->add_flag("--force,--overwrite", options.force,
                    "replace a scene that is there, and files that Thew did not write");
  add_json(*command, common);
  return command;
}

CLI::App* add_poses(CLI::App& app, CommandOptions& options) {
  CLI::App* command =
      app.add_subcommand("poses", "poses of a scene's skin, each by itself, to train deformers on");
  command->add_option("RANGES", options.input, "which poses: a file, TOML")->required();
  command->add_option("--out", options.out, ".h5, .npz or .glb")->required();
  add_option_repeated(*command, "--set", options.overrides,
                      "any key of the scene: skin.iterations=24");
  command->add_flag("--resume", options.resume, "go on with what an interrupted run left");
  add_overwrite(*command, options,
                "poses anew (with --resume: go on), and replace files that Thew did not write");
  add_threads(*command, options);
  add_progress(*command, options);
  add_json(*command, options);
  return command;
}

CLI::App* add_report(CLI::App& app, NightOptions& night, CommandOptions& options) {
  CLI::App* command = app.add_subcommand(
      "report",
      "one page over many bakes; ends with 0 if all are done and within their bounds, 1 if one "
      "misses a bound, failed, or is not done");
  command->add_option("DIR", night.folders, "bakes, or folders in which bakes are looked for")
      ->required();
  command->add_option("--html", night.html, "the page: one file, to read without a network");
  command->add_option("--json", night.json, "the same for programs; - is standard output");
  command->add_option("--against", night.against, "JSON of an earlier run: say what changed since");
  command
      ->add_option_function<std::string>(
          "--bounds", [&night](const std::string& word) { night.bounds_fail = word == "fail"; },
          "fail: a bound that is not met ends with 1; warn: it does not")
      ->check(CLI::IsMember({"fail", "warn"}));
  add_overwrite(*command, options);
  return command;
}

CLI::App* add_farm(CLI::App& app, CommandOptions& options, FarmChoice& choice) {
  CLI::App* command =
      app.add_subcommand("farm", "shots x characters x settings as jobs of an engine");
  command->add_option("JOBS", options.input, "which bakes: a file, TOML")->required();
  command->add_option("--slurm", choice.slurm, "FOLDER for submit.sh and what it submits");
  command->add_option("--openjd", choice.openjd, "FOLDER for job bundles, one a shot");
  command->add_flag("--local", choice.local, "run the tasks on this machine");
  command->add_flag("--submit", choice.submit, "with --slurm: run submit.sh");
  command->add_option("--out", options.out, "folder of the bakes; else as the file says");
  add_overwrite(*command, options, "replace files of jobs and pilot that Thew did not write");
  add_threads(*command, options);
  command->add_flag("--dry-run", options.dry_run, "read and check all, say what would be done");
  add_json(*command, options);
  return command;
}

CLI::App* add_compare(CLI::App& app, CommandOptions& options, fs::path& actual,
                      CompareOptions& compare, double& millimetres) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "two bakes, exports (.glb), PNGs or folders; ends with 0 if the same, 1 if different");
  command->add_option("EXPECTED", options.input, "bake, export (.glb), PNG or folder")->required();
  command->add_option("ACTUAL", actual, "the same kind")->required();
  command->add_option("--frames", options.frames, "those to compare");
  command->add_option("--html", options.out, "write a page with both, difference and slider");
  add_overwrite(*command, options);
  add_json(*command, options);
  add_threads(*command, options);
  add_progress(*command, options);
  add_limits(*command, compare, millimetres);
  return command;
}

// What update and check have in common.
void add_golden(CLI::App& command, CommandOptions& options, fs::path& golden) {
  command.add_option("SCENE", options.input, "scene file, TOML")->required();
  add_json(command, options);
  command.add_option("--golden", golden, "their folder; else golden/ beside the scene");
  command.add_option("--out", options.out, "keep what is baked here");
  add_overwrite(command, options);
  add_threads(command, options);
  add_progress(command, options);
  add_option_repeated(command, "--set", options.overrides,
                      "keys of the scene that differ for the goldens");
}

CLI::App* add_update(CLI::App& goldens, CommandOptions& options, fs::path& golden) {
  CLI::App* command = goldens.add_subcommand("update", "rewrite them on purpose, say what moved");
  add_golden(*command, options, golden);
  command->add_option("--frames", options.frames, "those to keep; else as before");
  return command;
}

CLI::App* add_check(CLI::App& goldens, CommandOptions& options, fs::path& golden,
                    CompareOptions& compare, double& millimetres) {
  CLI::App* command = goldens.add_subcommand("check", "bake the scene and compare with them");
  add_golden(*command, options, golden);
  add_limits(*command, compare, millimetres);
  return command;
}

// What measures Thew is a program of its own, installed beside this one.
constexpr const char* kLaboratory = "thew-lab";
constexpr std::array<std::array<const char*, 2>, 2> kLaboratoryCommands = {
    {{"chart", "speed against accuracy of a scene's muscles"},
     {"paper", "the paper's tables and figures, ours beside them"}}};

// Replaces the process by that program where one of its commands is called.
void become_laboratory(const Call& call, char** argv) {
  const auto word = std::find_if(call.words.begin() + 1, call.words.end(),
                                 [](const std::string& one) { return one[0] != '-'; });
  if (word == call.words.end()) return;
  const auto is_called = [&](const auto& command) { return *word == command[0]; };
  if (std::none_of(kLaboratoryCommands.begin(), kLaboratoryCommands.end(), is_called)) return;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / kLaboratory;
  ::execv(program.c_str(), argv);
  throw Error(ErrorCode::kInput, program.string() + ": cannot be started (" + std::strerror(errno) +
                                     "); install it beside thew, for " + *word);
}

// What the command line says, but for the options that several commands share; and the command.
struct Arguments {
  NewOptions create;
  CompareOptions compare;
  double millimetres = 1e3 * kDistanceTolerance;
  fs::path scene, repaired, maps, actual, golden;
  std::vector<std::string> meshes;
  ExportChoice onto;
  NightOptions night;
  FarmChoice farm;
  int turntable = 0, basis = 0;
  bool keys = false;
  std::function<ExitCode(CommandOptions&)> run;
};

void declare(CLI::App& app, CommandOptions& options, Arguments& a) {
  const auto runs = [&a](CLI::App* command, std::function<ExitCode(CommandOptions&)> run) {
    command->final_callback([&a, run = std::move(run)] { a.run = run; });
  };
  runs(add_bake(app, options), bake_command);
  runs(add_render(app, options, a.scene, a.turntable),
       [&a](CommandOptions& o) { return render_command(o, a.scene, a.turntable); });
  runs(add_export(app, options, a.meshes, a.basis, a.onto),
       [&a](CommandOptions& o) { return export_command(o, a.meshes, a.basis, a.onto); });
  runs(add_inspect(app, options, a.repaired, a.maps, a.keys), [&a](CommandOptions& o) {
    if (!a.keys) return inspect_command(o, a.repaired, a.maps);
    print(inspect_keys(o.json));
    return ExitCode::kDone;
  });
  runs(add_new(app, a.create, options), [&a](CommandOptions&) { return new_command(a.create); });
  runs(add_poses(app, options), poses_command);
  runs(add_report(app, a.night, options),
       [&a](CommandOptions& o) { return report_command(a.night, o); });
  runs(add_farm(app, options, a.farm), [&a](CommandOptions& o) { return farm_command(o, a.farm); });
  runs(add_compare(app, options, a.actual, a.compare, a.millimetres),
       [&a](CommandOptions& o) { return compare_command(o.input, a.actual, o, a.compare); });
  CLI::App* goldens = app.add_subcommand("golden", "goldens of a scene, beside it or elsewhere");
  goldens->require_subcommand(1);
  add_json(*goldens, options);
  runs(add_update(*goldens, options, a.golden),
       [&a](CommandOptions& o) { return golden_update_command(o, a.golden); });
  runs(add_check(*goldens, options, a.golden, a.compare, a.millimetres),
       [&a](CommandOptions& o) { return golden_check_command(o, a.golden, a.compare); });
  for (const auto& [name, what] : kLaboratoryCommands) app.add_subcommand(name, what);
}

ExitCode run(CommandOptions& options, Call& call, Arguments& a) {
  if (!a.create.out.empty()) call.out = a.create.out;
  if (a.night.json == "-") call.json = options.json = true;
  a.create.json = options.json;
  a.compare.distance = 1e-3 * a.millimetres;
  if (a.golden.empty()) a.golden = options.input.parent_path() / "golden";
  return a.run(options);
}

int run_command_line(int argc, char** argv) {
  Arguments arguments;
  return program_main(
      argc, argv,
      {.commit = kCommit,
       .begin = become_laboratory,
       .declare = [&](CLI::App& app, CommandOptions& options) { declare(app, options, arguments); },
       .run = [&](CommandOptions& options, Call& call) { return run(options, call, arguments); }});
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) { return thew::tools::run_command_line(argc, argv); }
