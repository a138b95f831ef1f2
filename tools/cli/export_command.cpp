// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "rig/skeleton.h"
#include "sim/cache/own_files.h"
#include "tools/base/printing.h"
#include "tools/cli/commands.h"
#include "tools/export/formats.h"
#include "tools/export/sequence.h"

namespace thew::tools {
namespace {

const std::vector<std::string> kEndings = {".pc2", ".mdd",  ".obj",  ".ply", ".glb",
                                           ".xmf", ".xdmf", ".usda", ".abc"};

[[noreturn]] void refuse_ending(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  const std::string near = nearest_name(ending, kEndings);
  std::string all;
  for (const std::string& one : kEndings) all += (all.empty() ? "" : " ") + one;
  throw Error(ErrorCode::kUsage, file.string() + ": no format has the ending \"" + ending + "\"; " +
                                     (near.empty() ? "" : "did you mean " + near + "? ") +
                                     "the endings are " + all);
}

// All that will be written; so that what is not ours is told before any work is done.
std::vector<std::filesystem::path> files_of(const Shot& shot, const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending == ".pc2" || ending == ".mdd") return {file, rest_file(file)};
  if (ending != ".obj" && ending != ".ply") return {file};
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < shot.places.size(); ++i) {
    files.push_back(sequence_file(file, shot.frame(i)));
  }
  return files;
}

Exported write(const Shot& shot, const CommandOptions& options, int basis) {
  const std::filesystem::path& file = options.out;
  const std::string ending = file.extension().string();
  if (basis > 0 && ending != ".glb") {
    throw Error(ErrorCode::kUsage, "--basis is for .glb only; " + file.string() +
                                       " holds every frame exactly, leave --basis out");
  }
  if (ending == ".pc2") return export_pc2(shot, file);
  if (ending == ".mdd") return export_mdd(shot, file);
  if (ending == ".obj") return export_obj(shot, file);
  if (ending == ".ply") return export_ply(shot, file);
  if (ending == ".glb") return export_glb(shot, file, basis);
  if (ending == ".xmf" || ending == ".xdmf") return export_xdmf(shot, file, options.input);
  if (ending == ".usda") return export_usda(shot, file);
  if (ending == ".abc") return export_alembic(shot, file);
  refuse_ending(file);
}

void tell(const Shot& shot, const Exported& exported, bool as_json) {
  std::vector<std::string> files, meshes;
  for (const auto& file : exported.files) files.push_back(file.string());
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) meshes.push_back(shot.mesh(m).name);
  if (as_json) {
    nlohmann::ordered_json json = {{"files", files}, {"meshes", meshes}};
    for (const auto& [name, value] : facts_of(shot)) json[name] = value;
    if (!exported.note.empty()) json["note"] = exported.note;
    return print_json(json);
  }
  std::string names;
  for (const std::string& name : meshes) names += (names.empty() ? "" : ", ") + name;
  std::string text = files.front() + (files.size() > 1 ? " to " + files.back() : "") +
                     "\n  meshes: " + names + "\n";
  for (const auto& [name, value] : facts_of(shot)) text += "  " + name + ": " + value + "\n";
  if (!exported.note.empty()) text += "  " + exported.note + "\n";
  print(text);
}

}  // namespace

ExitCode export_command(const CommandOptions& options, const std::vector<std::string>& meshes,
                        int basis) {
  const BakeReader reader(options.input);
  Shot shot = choose_shot(reader, meshes, options.frames);
  shot.progress = progress_style(options);
  claim(files_of(shot, options.out), options.overwrite);
  tell(shot, write(shot, options, basis), options.json);
  return ExitCode::kDone;
}

}  // namespace thew::tools
