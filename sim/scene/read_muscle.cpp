// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/read_muscle.h"

#include <algorithm>
#include <cmath>

#include "muscles/activation.h"
#include "muscles/volume_zones.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/muscle_keys.h"
#include "sim/scene/read_map.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

// More nodes than a muscle needs: a slip in a scene must not exhaust the memory.
constexpr int kTubeNodes = 100000;

void read_tube(TomlValue& table, TubeProfile& profile) {
  read(table, kProfile["around"], profile.around);
  read(table, kProfile["rings"], profile.rings);
  if (TomlValue* rings = find(table, kProfile["rings"]);
      profile.around * profile.rings > kTubeNodes) {
    refuse(*rings, "with around = " + std::to_string(profile.around) + " that is more than " +
                       std::to_string(kTubeNodes) + " nodes; make one of them smaller");
  }
  profile.radius = pairs_of(require(table, kProfile["radius"]), kProfile["radius"]);
}

// A point of the path that takes a share of how its body turns against another.
ScenePathPoint read_shared_point(TomlValue& table, bool is_end) {
  ScenePathPoint point{text_of(require(table, kPathPoint["body"])),
                       vector_of(require(table, kPathPoint["at"]), kPathPoint["at"].range),
                       table.location};
  TomlValue& with = require(table, kPathPoint["with"]);
  point.with = text_of(with);
  point.share = number_of(require(table, kPathPoint["share"]), kPathPoint["share"].range);
  if (point.with == point.body) refuse(with, "name another body than the point's own");
  if (is_end) {
    refuse(with, "give it to a point between origin and insertion, which are each on one body");
  }
  return point;
}

void read_path(TomlValue& value, std::vector<ScenePathPoint>& path) {
  std::vector<TomlValue>& items = items_of(value, kMuscle["path"].form, 2, kMostPathPoints);
  for (TomlValue& item : items) {
    if (item.type == TomlValue::Type::kTable) {
      path.push_back(read_shared_point(item, path.empty() || path.size() + 1 == items.size()));
      continue;
    }
    const std::vector<TomlValue>& parts = items_of(item, "a point, [\"body\", x, y, z]", 4, 4);
    const Range& range = kMuscle["path"].range;
    const Vec3 position(number_of(parts[1], range), number_of(parts[2], range),
                        number_of(parts[3], range));
    path.push_back({text_of(parts[0]), position, item.location});
  }
}

SceneWrap read_wrap(TomlValue& table, int segments) {
  SceneWrap wrap;
  wrap.location = table.location;
  wrap.segment = integer_of(require(table, kWrap["segment"]), {0, segments - 1.0});
  wrap.body = text_of(require(table, kWrap["body"]));
  wrap.centre = vector_of(require(table, kWrap["centre"]), kWrap["centre"].range);
  TomlValue& axis = require(table, kWrap["axis"]);
  wrap.axis = vector_of(axis, kWrap["axis"].range);
  if (wrap.axis.norm() < 1e-9) refuse(axis, "give a direction, which is not zero");
  wrap.radius = number_of(require(table, kWrap["radius"]), kWrap["radius"].range);
  if (const TomlValue* turn = find(table, kWrap["turn"])) {
    wrap.turn = integer_of(*turn, kWrap["turn"].range);
    if (wrap.turn == 0.0) refuse(*turn, "give 1 or -1");
  }
  return wrap;
}

SceneFixed read_fixed(TomlValue& table) {
  SceneFixed fixed;
  fixed.location = table.location;
  fixed.body = text_of(require(table, kFixed["body"]));
  read(table, kFixed["low"], fixed.low);
  read(table, kFixed["high"], fixed.high);
  return fixed;
}

ZoneSettings read_zone(TomlValue& table) {
  ZoneSettings zone;
  read(table, kZone["smallest_radius"], zone.smallest_radius);
  read(table, kZone["per_impulse"], zone.per_impulse);
  read(table, kZone["along_load"], zone.along_load);
  if (const TomlValue* largest = find(table, kZone["largest_radius"])) {
    zone.largest_radius =
        number_of(*largest, {zone.smallest_radius, kZone["largest_radius"].range.most});
  }
  return zone;
}

void read_weights(TomlValue& value, const Folders& folders, double size, SceneMuscle& muscle) {
  if (value.type != TomlValue::Type::kTable) {
    muscle.weights.keys = preset_profile(word_of(value, kMuscle["weights"])).keys;
  } else if (TomlValue* zone = find(value, kWeights["zone"])) {
    muscle.zone = read_zone(*zone);
  } else {
    muscle.weights = read_map(value, kMuscle["weights"], folders, size);
  }
}

// The order is that of MeshTransform.
Eigen::Affine3d read_transform(TomlValue& table) {
  MeshTransform transform;
  read(table, kTransform["scale"], transform.scale);
  if (TomlValue* axis = find(table, kTransform["axis"])) {
    transform.axis = direction_of(*axis, kTransform["axis"].range);
  }
  read(table, kTransform["angle"], transform.angle);
  read(table, kTransform["move"], transform.move);
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() = transform.scale * rotation_about(transform.axis, transform.angle * kDegree);
  out.translation() = transform.move;
  return out;
}

void read_material(TomlValue& table, const Folders& folders, double size, SceneMuscle& muscle) {
  SpringMaterial& material = muscle.material;
  read_number_or_map(table, kMaterial["stiffness"], folders, size, material.stiffness,
                     muscle.stiffness);
  read(table, kMaterial["anisotropy"], material.anisotropy);
  read(table, kMaterial["shear"], material.shear);
  read(table, kMaterial["bending"], material.bending);
  read(table, kMaterial["shape"], material.shape);
  read(table, kMaterial["density"], material.density);
}

void read_belly(TomlValue& value, std::array<double, 2>& belly) {
  const std::vector<TomlValue>& ends = items_of(value, kMuscle["belly"].form, 2, 2);
  const Range& range = kMuscle["belly"].range;
  belly = {number_of(ends[0], range), number_of(ends[1], range)};
  if (belly[1] <= belly[0]) refuse(ends[1], "give more than " + number_text(belly[0]));
}

JointActivation read_joint_activation(TomlValue& table) {
  JointActivation by;
  by.joint = text_of(require(table, kActivation["joint"]));
  TomlValue* preset = find(table, kActivation["preset"]);
  TomlValue* curve = find(table, kActivation["curve"]);
  if (preset && curve) refuse(*preset, "remove it, or the curve");
  if (preset) by.curve = activation_preset(word_of(*preset, kActivation["preset"]));
  if (curve) by.curve = pairs_of(*curve, kActivation["curve"]);
  if (TomlValue* speed = find(table, kActivation["speed"])) {
    by.speed = pairs_of(*speed, kActivation["speed"]);
  }
  if (TomlValue* load = find(table, kActivation["load"])) {
    by.load = muscles::JointActivation::Load{};
    by.load->mass = number_of(require(*load, kLoad["mass"]), kLoad["mass"].range);
    by.load->body = text_of(require(*load, kLoad["body"]));
    by.load->at = vector_of(require(*load, kLoad["at"]), kLoad["at"].range);
  }
  if (by.curve.empty() && by.speed.empty() && !by.load) {
    refuse(table, "give a preset, a curve, a speed or a load beside the joint");
  }
  return by;
}

// Reads what only a muscle with a path has.
void read_along_path(TomlValue& table, SceneMuscle& muscle) {
  for (TomlValue* wrap : tables_of(table, kMuscle["wrap"])) {
    muscle.wraps.push_back(read_wrap(*wrap, static_cast<int>(muscle.path.size()) - 1));
  }
  if (TomlValue* belly = find(table, kMuscle["belly"])) read_belly(*belly, muscle.belly);
  read(table, kMuscle["twist_from"], muscle.twist_from);
  muscle.shape = read_word(table, kMuscle["shape"]) == "target" ? SceneMuscle::Shape::kTarget
                                                                : SceneMuscle::Shape::kWeights;
  read(table, kMuscle["guide"], muscle.guide);
  read(table, kMuscle["f_max"], muscle.f_max);
  read(table, kMuscle["fibre_length"], muscle.fibre_length);
  if (TomlValue* activation = find(table, kMuscle["activation"])) {
    if (activation->type == TomlValue::Type::kTable) {
      muscle.by_joint = read_joint_activation(*activation);
    } else {
      muscle.activation = pairs_of(*activation, "[frame, activation]", kMuscle["activation"]);
    }
  }
}

// A soft body has no carried shape to be drawn to; it may be held by bodies.
void read_soft_body(TomlValue& table, SceneMuscle& muscle) {
  muscle.shape = SceneMuscle::Shape::kWeights;
  muscle.guide = muscle.damping = muscle.material.shape = 0.0;
  for (TomlValue* fixed : tables_of(table, kMuscle["fixed"]))
    muscle.fixed.push_back(read_fixed(*fixed));
  if (TomlValue* material = find(table, kMuscle["material"])) {
    if (TomlValue* shape = find(*material, kMaterial["shape"])) {
      if (number_of(*shape, kMaterial["shape"].range) != 0.0)
        refuse(*shape, "remove it: a body without a path has no carried shape");
    }
  }
}

}  // namespace

SceneMuscle read_muscle(TomlValue& table, const Folders& folders, double size) {
  SceneMuscle muscle;
  muscle.fibre_length *= size;
  muscle.location = table.location;
  muscle.name = name_of(require(table, kMuscle["name"]));
  const auto [kind, form] = require_one(table, {&kMuscle["mesh"], &kMuscle["profile"]});
  if (kind == "mesh") {
    muscle.mesh = file_of(*form, folders);
    if (TomlValue* given = find(table, kMuscle["transform"])) {
      muscle.mesh_to_rest = read_transform(*given);
    }
  }
  read(table, kMuscle["mirror"], muscle.mirror);
  if (muscle.mirror) {
    if (kind != "mesh") refuse(*find(table, kMuscle["mirror"]), "remove it: a profile has no mesh");
    const Eigen::Affine3d flip(Eigen::Scaling(-1.0, 1.0, 1.0));
    muscle.mesh_to_rest = flip * muscle.mesh_to_rest;
  }
  if (kind == "profile") read_tube(*form, muscle.profile);
  TomlValue* path = find(table, kMuscle["path"]);
  const bool has_path = path || kind == "profile";  // a profile runs along a path
  if (has_path) read_path(path ? *path : require(table, kMuscle["path"]), muscle.path);
  if (has_path) {
    read_along_path(table, muscle);
  } else {
    read_soft_body(table, muscle);
  }
  if (TomlValue* weights = find(table, kMuscle["weights"]))
    read_weights(*weights, folders, size, muscle);
  read(table, kMuscle["damping"], muscle.damping);
  if (TomlValue* material = find(table, kMuscle["material"]))
    read_material(*material, folders, size, muscle);
  if (muscle.mirror) {
    for (NodeMap* map : {&muscle.weights, &muscle.stiffness}) mirror_map(*map);
  }
  read(table, kMuscle["colour"], muscle.colour);
  read(table, kMuscle["zones"], muscle.zones);
  return muscle;
}

}  // namespace thew::sim
