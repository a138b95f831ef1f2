// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <nlohmann/json.hpp>

#include "rig/import/gltf_source.h"
#include "rig/skeleton.h"
#include "rig/text.h"
#include "sim/cache/own_files.h"
#include "tools/base/printing.h"
#include "tools/cli/commands.h"
#include "tools/export/character_skin.h"
#include "tools/export/formats.h"
#include "tools/export/looks.h"
#include "tools/export/own_mesh.h"
#include "tools/export/sequence.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kEndings = {".pc2",  ".mdd",  ".obj",  ".ply",  ".glb", ".xmf",
                                           ".xdmf", ".usda", ".usdc", ".usdz", ".abc"};

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
  if (ending == ".obj") files.push_back(materials_file(file));
  return files;
}

// The file of the bake's character: as the scene named it, which the report beside the bake knows;
// or beside the bake's folder, where `thew new` puts scene and character. "" where neither is.
fs::path find_character(const fs::path& bake, const std::string& name) {
  constexpr size_t kLongestReport = size_t{64} << 20;  // bytes
  const fs::path folder = fs::absolute(bake).parent_path(), report = folder / "report.json";
  std::vector<fs::path> scenes;
  std::error_code error;
  if (fs::is_regular_file(report, error)) {
    const auto json = nlohmann::json::parse(read_whole(report, kLongestReport), nullptr, false);
    const auto origin = json.is_object() ? json.value("origin", nlohmann::json()) : json;
    if (origin.is_object() && origin.contains("scene") && origin["scene"].is_string()) {
      scenes.push_back(fs::path(origin["scene"].get<std::string>()).parent_path());
    }
  }
  scenes.push_back(folder.parent_path());
  for (const fs::path& scene : scenes) {
    fs::path file = (scene / name).lexically_normal();
    if (fs::is_regular_file(file, error)) return file;
  }
  return {};
}

// Formats of the bake's meshes that hold texture coordinates.
bool takes_looks(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".obj" || ending == ".abc" || ending.starts_with(".usd");
}

// Formats that hold values by node and frame.
bool holds_fields(const fs::path& file) {
  return file.extension() == ".abc" || file.extension().string().starts_with(".usd");
}

bool is_point_cache(const fs::path& file) {
  return file.extension() == ".pc2" || file.extension() == ".mdd";
}

// An artist's own mesh, for formats with polygons or with vertices alone.
bool names_own_mesh(const fs::path& character) { return character.extension() == ".obj"; }

/// Onto which character's file the skin goes; "" for none.
struct Onto {
  fs::path character;
  std::string note;  ///< why it is none, where a user may have expected one
};

Onto choose_onto(const Shot& shot, const CommandOptions& options, const ExportChoice& choice,
                 bool meshes_chosen) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::kUsage, what); };
  const bool asked = !choice.character.empty() && choice.character != "none";
  const bool glb = options.out.extension() == ".glb";
  if (!glb && (choice.correctives || (asked && !takes_looks(options.out)))) {
    refuse((asked ? "--onto" : "--correctives") + std::string(" is not for ") +
           options.out.string() + ", which holds the meshes of the bake; leave it out");
  }
  if (!glb && !takes_looks(options.out)) return {};
  if (glb && meshes_chosen && (asked || choice.correctives)) {
    refuse(
        "--mesh chooses meshes of the bake, and --onto writes those of the character; leave one "
        "of them out");
  }
  if (asked && !names_gltf(choice.character) && (glb || !names_own_mesh(choice.character))) {
    refuse("--onto " + choice.character.string() + ": is no .gltf, .glb or .vrm" +
           (glb ? "; convert the character to one, and bake that"
                : ", and no .obj of the skin; export it as one of them"));
  }
  if (asked) return {choice.character, ""};
  const std::string& name = shot.info().character.file;
  Onto onto;
  if (choice.character.empty() && !(glb && meshes_chosen) && names_gltf(name)) {
    onto.character = find_character(options.input, name);
    if (onto.character.empty() && glb) {
      onto.note =
          "\n  the character " + name +
          " is not where the scene had it, so that these are the bake's meshes; --onto FILE "
          "puts the skin back onto it";
    }
  }
  if (choice.correctives && onto.character.empty()) {
    refuse("--correctives needs the character's .gltf, .glb or .vrm; give it by --onto");
  }
  return onto;
}

// Of a character that was not asked for and is not as it was baked, nothing is taken.
void take_looks(const CommandOptions& options, const ExportChoice& choice, Onto& onto, Shot& shot) {
  const auto& meshes = shot.meshes;
  if (onto.character.empty() ||
      std::find(meshes.begin(), meshes.end(), skin_mesh(shot.info())) == meshes.end()) {
    return;
  }
  if (names_own_mesh(onto.character)) {
    return put_onto_own_mesh(onto.character,
                             find_character(options.input, shot.info().character.file), shot);
  }
  try {
    shot.looks = read_skin_looks(shot, onto.character);
    shot.smooth[skin_mesh(shot.info())] = shot.looks.smooth;
    if (!shot.looks.unread.empty()) {
      onto.note = "\n  without the materials of " + onto.character.string() +
                  ", which could not be read; export it again: " + shot.looks.unread;
    }
  } catch (const Error& error) {
    if (!choice.character.empty()) throw;
    onto.note = std::string("\n  without texture coordinates of the skin: ") + error.what();
  }
}

Exported write(const Shot& shot, const CommandOptions& options, const GlbOptions& glb,
               const Onto& onto) {
  const std::filesystem::path& file = options.out;
  const std::string ending = file.extension().string();
  if (glb.basis > 0 && ending != ".glb") {
    throw Error(ErrorCode::kUsage, "--basis is for .glb only; " + file.string() +
                                       " holds every frame exactly, leave --basis out");
  }
  const auto noted = [&](Exported exported) {
    exported.note += onto.note;
    return exported;
  };
  if (ending == ".pc2") return noted(export_pc2(shot, file));
  if (ending == ".mdd") return noted(export_mdd(shot, file));
  if (ending == ".obj") return noted(export_obj(shot, file));
  if (ending == ".ply") return export_ply(shot, file);
  if (ending == ".glb") return noted(export_glb(shot, file, glb));
  if (ending == ".xmf" || ending == ".xdmf") return export_xdmf(shot, file, options.input);
  if (ending == ".usda" || ending == ".usdc" || ending == ".usdz") {
    return noted(export_usd(shot, file));
  }
  if (ending == ".abc") return noted(export_alembic(shot, file));
  refuse_ending(file);
}

// One point cache for each mesh of the character.
Exported write_caches_onto(Shot& shot, const CommandOptions& options, const ExportChoice& choice,
                           bool meshes_chosen) {
  const bool own = names_own_mesh(choice.character);
  if (meshes_chosen || choice.correctives || !(own || names_gltf(choice.character))) {
    throw Error(ErrorCode::kUsage,
                "--onto " + choice.character.string() + " for " + options.out.string() +
                    " takes a .gltf, .glb or .vrm, whose skin it writes, or an .obj of that, "
                    "without --mesh and --correctives; leave these out");
  }
  const int skin = skin_mesh(shot.info());
  if (skin < 0) {
    throw Error(ErrorCode::kUsage, "--onto: the bake has no skin; leave it out");
  }
  shot.meshes = {skin};
  if (own) {
    put_onto_own_mesh(choice.character, find_character(options.input, shot.info().character.file),
                      shot);
    claim({options.out, rest_file(options.out)}, options.overwrite);
    Onto onto;
    onto.note = "; on an object with Z up, Forward to Z and Up to -Y";
    return write(shot, options, {}, onto);
  }
  const std::vector<CachedNode> nodes = point_cache_nodes(shot, options.out, choice.character);
  std::vector<fs::path> files;
  for (const CachedNode& node : nodes) {
    files.push_back(node.file);
    files.push_back(rest_file(node.file));
  }
  claim(files, options.overwrite);
  return export_point_caches_onto(shot, nodes);
}

nlohmann::ordered_json told(const Shot& shot, const Exported& exported) {
  std::vector<std::string> files, meshes;
  for (const auto& file : exported.files) files.push_back(file.string());
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) meshes.push_back(shot.mesh(m).name);
  nlohmann::ordered_json json = {{"files", files}, {"meshes", meshes}};
  for (const auto& [name, value] : facts_of(shot)) json[name] = value;
  if (!exported.note.empty()) json["note"] = exported.note;
  return json;
}

// For people.
std::string as_text(const nlohmann::ordered_json& told) {
  const auto files = told["files"].get<std::vector<std::string>>();
  std::string names, facts;
  for (const auto& name : told["meshes"]) {
    names += (names.empty() ? "" : ", ") + name.get<std::string>();
  }
  for (const auto& [name, value] : told.items()) {
    if (name == "files" || name == "meshes") continue;
    facts += "  " + (name == "note" ? "" : name + ": ") + value.get<std::string>() + "\n";
  }
  const auto ending = [](const std::string& file) { return fs::path(file).extension(); };
  const bool sequence = files.size() > 1 && ending(files.front()) == ending(files.back());
  return files.front() + (files.size() > 1 ? (sequence ? " to " : " and ") + files.back() : "") +
         "\n  meshes: " + names + "\n" + facts;
}

}  // namespace

nlohmann::ordered_json export_bake(const CommandOptions& options,
                                   const std::vector<std::string>& meshes, int basis,
                                   const ExportChoice& choice) {
  const BakeReader reader(options.input);
  Shot shot = choose_shot(reader, meshes, options.frames);
  shot.progress = progress_style(options);
  shot.fields = choice.fields;
  if (choice.quantized && (options.out.extension() != ".glb" || basis > 0)) {
    throw Error(ErrorCode::kUsage, "--quantized is for .glb without --basis; leave it out");
  }
  if (choice.fields && !holds_fields(options.out)) {
    throw Error(ErrorCode::kUsage, "--fields is not for " + options.out.string() +
                                       ", which has no place for them; leave it out, or write "
                                       ".usdc or .abc");
  }
  if (is_point_cache(options.out) && !choice.character.empty() && choice.character != "none") {
    return told(shot, write_caches_onto(shot, options, choice, !meshes.empty()));
  }
  claim(files_of(shot, options.out), options.overwrite);
  Onto onto = choose_onto(shot, options, choice, !meshes.empty());
  if (takes_looks(options.out)) {
    take_looks(options, choice, onto, shot);
    if (options.out.extension().string().starts_with(".usd")) {
      claim(usd_images(shot, options.out), options.overwrite);
    }
  } else if (!onto.character.empty()) {
    if (choice.quantized) {
      throw Error(
          ErrorCode::kUsage,
          "--quantized is for the bake's own meshes; give --onto none too, or leave it out");
    }
    shot.meshes = {skin_mesh(shot.info())};
    return told(shot,
                export_glb_onto(shot, {options.out, onto.character, choice.correctives, basis}));
  }
  return told(shot, write(shot, options, {basis, choice.quantized}, onto));
}

ExitCode export_command(const CommandOptions& options, const std::vector<std::string>& meshes,
                        int basis, const ExportChoice& choice) {
  const nlohmann::ordered_json told = export_bake(options, meshes, basis, choice);
  if (options.json) {
    print_json(told);
  } else {
    print(as_text(told));
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
