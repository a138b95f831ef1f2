// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/read_rig.h"

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "sim/cache/cached_mesh.h"
#include "sim/scene/rig_keys.h"

namespace thew::sim {
namespace {

SceneForearm read_forearm(TomlValue& table) {
  SceneForearm forearm;
  forearm.ulna = text_of(require(table, kForearm["ulna"]));
  forearm.radius = text_of(require(table, kForearm["radius"]));
  forearm.head = vector_of(require(table, kForearm["head"]), kForearm["head"].range);
  TomlValue& wrist = require(table, kForearm["wrist"]);
  forearm.wrist = vector_of(wrist, kForearm["wrist"].range);
  if (forearm.wrist.norm() < 1e-6 || (forearm.wrist - forearm.head).norm() < 1e-6) {
    refuse(wrist, "give another place than the body's origin and the radius' head");
  }
  return forearm;
}

SceneScapula read_scapula(TomlValue& table) {
  SceneScapula scapula;
  scapula.body = text_of(require(table, kScapula["body"]));
  scapula.on = text_of(require(table, kScapula["on"]));
  scapula.axis = direction_of(require(table, kScapula["axis"]), kScapula["axis"].range);
  scapula.hanging = direction_of(require(table, kScapula["hanging"]), kScapula["hanging"].range);
  if (TomlValue* from = find(table, kScapula["from"])) {
    scapula.from = number_of(*from, kScapula["from"].range) * kDegree;
  }
  read(table, kScapula["share"], scapula.share);
  return scapula;
}

SceneHinge read_hinge(TomlValue& table) {
  SceneHinge hinge;
  hinge.location = table.location;
  hinge.name = text_of(require(table, kHinge["name"]));
  hinge.body = text_of(require(table, kHinge["body"]));
  hinge.axis = direction_of(require(table, kHinge["axis"]), kHinge["axis"].range);
  read(table, kHinge["at_bind"], hinge.at_bind);
  hinge.at_bind *= kDegree;
  read(table, kHinge["roll"], hinge.roll);
  hinge.roll *= kDegree;
  if (hinge.roll != 0.0) {
    hinge.along = direction_of(require(table, kHinge["along"]), kHinge["along"].range);
  }
  if (TomlValue* range = find(table, kHinge["range"])) {
    const std::vector<TomlValue>& ends = items_of(*range, kHinge["range"].form, 2, 2);
    for (int i = 0; i < 2; ++i) {
      hinge.range[i] = number_of(ends[i], kHinge["range"].range) * kDegree;
    }
    if (hinge.range[1] < hinge.range[0]) refuse(ends[1], "give no less than the first");
  }
  if (TomlValue* forearm = find(table, kHinge["forearm"])) hinge.forearm = read_forearm(*forearm);
  if (TomlValue* scapula = find(table, kHinge["scapula"])) hinge.scapula = read_scapula(*scapula);
  return hinge;
}

}  // namespace

void read_character_rig(TomlValue& table, const Folders& folders, Scene& scene) {
  SceneCharacter& character = scene.character;
  character.given = true;
  read(table, kRig["scale"], character.scale);
  for (TomlValue* hinge : tables_of(table, kRig["hinge"])) {
    character.hinges.push_back(read_hinge(*hinge));
  }
  for (TomlValue* bone : tables_of(table, kRig["bone"])) {
    character.bones.push_back({name_of(require(*bone, kBone["name"])),
                               text_of(require(*bone, kBone["body"])),
                               file_of(require(*bone, kBone["mesh"]), folders),
                               {},
                               bone->location});
  }
}

std::optional<double> read_frame(TomlValue& table, const Key& key) {
  TomlValue* frame = find(table, key);
  return frame ? std::optional(number_of(*frame, key.range)) : std::nullopt;
}

void read_cached_rig(TomlValue& table, const Folders& folders, Scene& scene) {
  SceneCachedRig& rig = scene.cached_rig;
  rig.given = true;
  read(table, kRig["scale"], rig.scale);
  rig.start = read_frame(table, kRig["start"]);
  rig.bind = read_frame(table, kRig["bind"]);
  if (TomlValue* clip = find(table, kRig["clip"])) {
    throw Error(ErrorCode::kUsage,
                clip->location +
                    ": [rig.clip] beside cached bones, which move by their cache; "
                    "remove one of them");
  }
  if (!scene.rig.empty()) return;
  for (TomlValue* bone : tables_of(table, kRig["bone"])) {
    const std::string name = name_of(require(*bone, kBone["name"]));
    scene.character.bones.push_back({name, name, file_of(require(*bone, kBone["mesh"]), folders),
                                     file_of(require(*bone, kBone["cache"]), folders),
                                     bone->location});
  }
}

SceneCollider read_collider(TomlValue& table, const Folders& folders) {
  SceneCollider collider;
  collider.location = table.location;
  collider.name = name_of(require(table, kCollider["name"]));
  read(table, kCollider["scale"], collider.scale);
  TomlValue* cache = find(table, kCollider["cache"]);
  if (cache) {
    collider.cache = file_of(*cache, folders);
    collider.start = read_frame(table, kCollider["start"]);
  }
  if (cache && names_bake(collider.cache)) {
    if (TomlValue* part = find(table, kCollider["part"])) collider.part = text_of(*part);
  } else {
    collider.mesh = file_of(require(table, kCollider["mesh"]), folders);
  }
  return collider;
}

bool read_character_clip(TomlValue& table, const Folders& folders, Scene& scene) {
  SceneCharacter& character = scene.character;
  TomlValue* file = find(table, kClip["file"]);
  const bool is_text = file && file->type == TomlValue::Type::kText;
  const bool motion = is_text && names_motion(file->text);
  if (const TomlValue* name = find(table, kClip["animation"])) {
    character.animation = text_of(*name);
    scene.clip_location = name->location;
    for (const Key* other : {&kClip["keys"], &kClip["file"]}) {
      TomlValue* both = find(table, *other);
      // Beside the file of another character, the name says which animation of that file.
      if (!both || (both == file && is_text && names_character(file->text))) continue;
      refuse(*both, "remove it, or the animation at " + name->location);
    }
    if (!motion) return true;
  }
  if (!motion) return false;
  scene.clip_location = file->location;
  character.motion = file_of(*file, folders);
  if (TomlValue* columns = find(table, kClip["columns"])) {
    const TomlValue& names = entries_of(*columns);
    for (size_t i = 0; i < names.items.size(); ++i) {
      character.motion_names.push_back({names.keys[i], text_of(names.items[i])});
    }
  }
  return true;
}

}  // namespace thew::sim
