// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/read_rig.h"

#include "rig/import/character_import.h"
#include "rig/math.h"

namespace thew::sim {
namespace {

SceneForearm read_forearm(TomlValue& table) {
  SceneForearm forearm;
  forearm.ulna = text_of(require(table, "ulna"));
  forearm.radius = text_of(require(table, "radius"));
  forearm.head = vector_of(require(table, "head"), kPlace);
  TomlValue& wrist = require(table, "wrist");
  forearm.wrist = vector_of(wrist, kPlace);
  if (forearm.wrist.norm() < 1e-6 || (forearm.wrist - forearm.head).norm() < 1e-6) {
    refuse(wrist, "give another place than the body's origin and the radius' head");
  }
  return forearm;
}

SceneHinge read_hinge(TomlValue& table) {
  SceneHinge hinge;
  hinge.location = table.location;
  hinge.name = text_of(require(table, "name"));
  hinge.body = text_of(require(table, "body"));
  hinge.axis = direction_of(require(table, "axis"));
  constexpr Range kTurn{-360.0, 360.0};
  read(table, "at_bind", hinge.at_bind, kTurn);
  hinge.at_bind *= kDegree;
  read(table, "roll", hinge.roll, kTurn);
  hinge.roll *= kDegree;
  if (hinge.roll != 0.0) hinge.along = direction_of(require(table, "along"));
  if (TomlValue* range = find(table, "range")) {
    const std::vector<TomlValue>& ends = items_of(*range, "degrees, [from, to]", 2, 2);
    hinge.range = {number_of(ends[0], kTurn) * kDegree, number_of(ends[1], kTurn) * kDegree};
    if (hinge.range[1] < hinge.range[0]) refuse(ends[1], "give no less than the first");
  }
  if (TomlValue* forearm = find(table, "forearm")) hinge.forearm = read_forearm(*forearm);
  return hinge;
}

}  // namespace

void read_character_rig(TomlValue& table, const Folders& folders, Scene& scene) {
  SceneCharacter& character = scene.character;
  character.given = true;
  read(table, "scale", character.scale, kScale);
  for (TomlValue* hinge : tables_of(table, "hinge")) {
    character.hinges.push_back(read_hinge(*hinge));
  }
  for (TomlValue* bone : tables_of(table, "bone")) {
    character.bones.push_back({name_of(require(*bone, "name")), text_of(require(*bone, "body")),
                               file_of(require(*bone, "mesh"), folders), bone->location});
  }
}

bool read_character_clip(TomlValue& table, const Folders& folders, Scene& scene) {
  SceneCharacter& character = scene.character;
  TomlValue* file = find(table, "file");
  const bool is_text = file && file->type == TomlValue::Type::kText;
  const bool motion = is_text && names_motion(file->text);
  if (const TomlValue* name = find(table, "animation")) {
    character.animation = text_of(*name);
    scene.clip_location = name->location;
    for (const char* other : {"keys", "file"}) {
      TomlValue* both = find(table, other);
      // Of another character's file, it says which.
      if (!both || (both == file && is_text && names_character(file->text))) continue;
      refuse(*both, "remove it, or the animation at " + name->location);
    }
    if (!motion) return true;
  }
  if (!motion) return false;
  scene.clip_location = file->location;
  character.motion = file_of(*file, folders);
  if (TomlValue* columns = find(table, "columns")) {
    const TomlValue& names = entries_of(*columns);
    for (size_t i = 0; i < names.items.size(); ++i) {
      character.motion_names.push_back({names.keys[i], text_of(names.items[i])});
    }
  }
  return true;
}

}  // namespace thew::sim
