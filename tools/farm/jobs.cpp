// SPDX-License-Identifier: Apache-2.0
#include "tools/farm/jobs.h"

#include <algorithm>

#include "rig/text.h"
#include "sim/scene/reader.h"
#include "sim/scene/values.h"
#include "tools/base/options.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using sim::Key;
using sim::KeyType;
using sim::TomlValue;

constexpr sim::Range kCount = {1, 1000000};
constexpr Key kJobKeys[] = {
    {.name = "out", .type = KeyType::kText, .meaning = ""},
    {.name = "threads", .type = KeyType::kInteger, .meaning = "", .range = {1, 1024}},
    {.name = "chunk", .type = KeyType::kInteger, .meaning = "", .range = kCount},
    {.name = "pictures", .type = KeyType::kInteger, .meaning = "", .range = kCount},
    {.name = "pilot", .type = KeyType::kInteger, .meaning = "", .range = kCount},
    {.name = "exports", .type = KeyType::kForm, .meaning = ""},
    {.name = "shot", .type = KeyType::kTables, .meaning = ""},
    {.name = "character", .type = KeyType::kTables, .meaning = ""},
    {.name = "setting", .type = KeyType::kTables, .meaning = ""}};
constexpr Key kPartKeys[] = {
    {.name = "name", .type = KeyType::kName, .meaning = "", .need = sim::Need::kRequired},
    {.name = "scene", .type = KeyType::kText, .meaning = ""},
    {.name = "set", .type = KeyType::kForm, .meaning = ""},
    {.name = "frames", .type = KeyType::kText, .meaning = ""},
    {.name = "characters", .type = KeyType::kForm, .meaning = ""}};
constexpr sim::Section kJobs{"", "", "", kJobKeys}, kPart{"", "", "", kPartKeys};
constexpr std::size_t kMostItems = 10000;

/// A [[shot]], a [[character]] or a [[setting]].
struct Part {
  std::string name, location, frames, scene;
  std::vector<std::string> set, characters;
};

std::vector<std::string> texts_of(TomlValue& table, const Key& key, const char* form) {
  std::vector<std::string> texts;
  if (TomlValue* value = find(table, key)) {
    for (const TomlValue& item : items_of(*value, form, 0, kMostItems)) {
      texts.push_back(text_of(item));
    }
  }
  return texts;
}

std::vector<Part> read_parts(TomlValue& root, const Key& key) {
  const std::string kind = key.name;
  std::vector<Part> parts;
  for (TomlValue* table : tables_of(root, key)) {
    Part part;
    const TomlValue& name = require(*table, kPart["name"]);
    part.name = name_of(name);
    part.location = table->location;
    const auto same = [&](const Part& other) { return other.name == part.name; };
    if (std::any_of(parts.begin(), parts.end(), same)) {
      refuse(name, "give each " + kind + " a name of its own");
    }
    part.set = texts_of(*table, kPart["set"], "keys of the scene, [\"solver.substeps=4\", ...]");
    if (kind != "setting") {
      if (const TomlValue* scene = find(*table, kPart["scene"])) part.scene = text_of(*scene);
    }
    if (kind == "shot") {
      if (const TomlValue* frames = find(*table, kPart["frames"])) part.frames = text_of(*frames);
      part.characters = texts_of(*table, kPart["characters"], "names of characters");
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

[[noreturn]] void refuse_part(const Part& part, const std::string& what) {
  throw Error(ErrorCode::kUsage, part.location + ": " + what);
}

std::vector<const Part*> characters_of(const Part& shot, const std::vector<Part>& characters) {
  std::vector<std::string> names;
  for (const Part& one : characters) names.push_back(one.name);
  for (const std::string& name : shot.characters) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    refuse_part(shot, "shot " + shot.name + ": there is no character \"" + name + "\"" +
                          rig::did_you_mean(name, names));
  }
  std::vector<const Part*> chosen;
  for (const Part& one : characters) {
    const auto& only = shot.characters;
    if (only.empty() || std::find(only.begin(), only.end(), one.name) != only.end()) {
      chosen.push_back(&one);
    }
  }
  return chosen;
}

ShotBake bake_of(const Jobs& jobs, const Part& shot, const Part& character, const Part& setting) {
  if (shot.scene.empty() == character.scene.empty()) {
    refuse_part(shot, "shot " + shot.name +
                          (shot.scene.empty() ? " has no scene; give it or its characters one"
                                              : ": its scene and its character's are two; keep "
                                                "one of them"));
  }
  ShotBake bake;
  bake.shot = bake.name = shot.name;
  for (const std::string& name : {character.name, setting.name}) {
    if (!name.empty()) bake.name += "/" + name;
  }
  bake.folder = jobs.out / bake.name;
  const std::string& scene = shot.scene.empty() ? character.scene : shot.scene;
  bake.scene = (jobs.file.parent_path() / scene).lexically_normal();
  bake.overrides = shot.set;
  bake.costs_as = scene;
  for (const Part* part : {&character, &setting}) {
    for (const std::string& set : part->set) {
      bake.overrides.push_back(set);
      bake.costs_as += " " + set;
    }
  }
  const sim::Scene read = sim::read_scene(bake.scene, bake.overrides);
  const std::string all = std::to_string(read.first_frame) + "-" + std::to_string(read.last_frame);
  bake.frames =
      parse_frames(shot.frames.empty() ? all : shot.frames, read.first_frame, read.last_frame);
  bake.simulated = bake.frames.back() - read.first_frame + 1;
  bake.stands_alone = !read.solver.tolerance && read.solver.integrator == "quasi_static";
  bake.has_views = !read.render.views.empty();
  return bake;
}

}  // namespace

Jobs read_jobs(const fs::path& file, const fs::path& out) {
  TomlValue root = sim::read_toml(file);
  Jobs jobs;
  jobs.file = fs::absolute(file).lexically_normal();
  const TomlValue* given = find(root, kJobs["out"]);
  jobs.out = out.empty() ? jobs.file.parent_path() / (given ? text_of(*given) : "bakes")
                         : fs::absolute(out);
  jobs.out = (jobs.out / "").lexically_normal().parent_path();
  read(root, kJobs["threads"], jobs.threads);
  read(root, kJobs["chunk"], jobs.chunk);
  read(root, kJobs["pictures"], jobs.pictures);
  read(root, kJobs["pilot"], jobs.pilot);
  jobs.exports = texts_of(root, kJobs["exports"], "names of files, [\"baked.usda\", ...]");
  for (const std::string& name : jobs.exports) {
    if (fs::path(name).is_absolute() || name.find("..") != std::string::npos) {
      refuse(*find(root, kJobs["exports"]), "give names in the folder of each bake");
    }
  }
  const std::vector<Part> shots = read_parts(root, kJobs["shot"]);
  std::vector<Part> characters = read_parts(root, kJobs["character"]);
  std::vector<Part> settings = read_parts(root, kJobs["setting"]);
  refuse_unknown_keys(root);
  if (shots.empty()) {
    throw Error(ErrorCode::kUsage, file.string() + ": has no [[shot]]; give one at least");
  }
  if (characters.empty()) characters.emplace_back();
  if (settings.empty()) settings.emplace_back();
  for (const Part& shot : shots) {
    for (const Part* character : characters_of(shot, characters)) {
      for (const Part& setting : settings) {
        jobs.bakes.push_back(bake_of(jobs, shot, *character, setting));
      }
    }
  }
  return jobs;
}

}  // namespace thew::tools
