// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/read_muscle.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume_zones.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/values.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kTubeNodes = 100000;
constexpr std::size_t kWeightFileLimit = std::size_t{16} << 20;  // bytes

void read_tube(TomlValue& table, TubeProfile& profile) {
  read(table, "around", profile.around, 3, 1000);
  read(table, "rings", profile.rings, 2, 1000);
  if (profile.around * profile.rings > kTubeNodes) {
    refuse(require(table, "rings"), "with around = " + std::to_string(profile.around) +
                                        " that is more than " + std::to_string(kTubeNodes) +
                                        " nodes; make one of them smaller");
  }
  profile.radius = pairs_of(require(table, "radius"), "[u, metres]", kShare, {1e-6, 10.0});
}

// A point that takes a share of how its body turns against another.
ScenePathPoint read_shared_point(TomlValue& table, bool is_end) {
  ScenePathPoint point{text_of(require(table, "body")), vector_of(require(table, "at"), kPlace),
                       table.location};
  TomlValue& with = require(table, "with");
  point.with = text_of(with);
  point.share = number_of(require(table, "share"), kShare);
  if (point.with == point.body) refuse(with, "name another body than the point's own");
  if (is_end) {
    refuse(with, "give it to a point between origin and insertion, which are each on one body");
  }
  return point;
}

void read_path(TomlValue& value, std::vector<ScenePathPoint>& path) {
  std::vector<TomlValue>& items =
      items_of(value, "two points or more, [[\"body\", x, y, z], ...]", 2, 1000);
  for (TomlValue& item : items) {
    if (item.type == TomlValue::Type::kTable) {
      path.push_back(read_shared_point(item, path.empty() || path.size() + 1 == items.size()));
      continue;
    }
    const std::vector<TomlValue>& parts = items_of(item, "a point, [\"body\", x, y, z]", 4, 4);
    const Vec3 position(number_of(parts[1], kPlace), number_of(parts[2], kPlace),
                        number_of(parts[3], kPlace));
    path.push_back({text_of(parts[0]), position, item.location});
  }
}

SceneWrap read_wrap(TomlValue& table, int segments) {
  SceneWrap wrap;
  wrap.location = table.location;
  wrap.segment = integer_of(require(table, "segment"), 0, segments - 1);
  wrap.body = text_of(require(table, "body"));
  wrap.centre = vector_of(require(table, "centre"), kPlace);
  TomlValue& axis = require(table, "axis");
  wrap.axis = vector_of(axis, kDirection);
  if (wrap.axis.norm() < 1e-9) refuse(axis, "give a direction, which is not zero");
  wrap.radius = number_of(require(table, "radius"), kSize);
  if (const TomlValue* turn = find(table, "turn")) {
    wrap.turn = integer_of(*turn, -1, 1);
    if (wrap.turn == 0.0) refuse(*turn, "give 1 or -1");
  }
  return wrap;
}

SceneFixed read_fixed(TomlValue& table) {
  SceneFixed fixed;
  fixed.location = table.location;
  fixed.body = text_of(require(table, "body"));
  read(table, "low", fixed.low, kPlace);
  read(table, "high", fixed.high, kPlace);
  return fixed;
}

// One weight a line, one line a vertex; or "x y z weight" a line, which finds its vertices.
void read_weight_file(const fs::path& file, SceneMuscle& muscle) {
  const std::string text = read_whole(file, kWeightFileLimit);
  std::size_t width = 0, line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const auto words = split_words(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    ++line;
    std::array<double, 4> values{};
    if (width == 0 && (words.size() == 1 || words.size() == 4)) width = words.size();
    bool good = width > 0 && words.size() == width;
    for (std::size_t k = 0; good && k < width; ++k) {
      const auto number = parse_number(words[k]);
      const bool weight = k + 1 == width;
      good = number && (weight ? *number >= 0.0 && *number <= kNotNegative.most
                               : std::abs(*number) <= kMaxCoordinate);
      if (good) values[k] = *number;
    }
    if (!good) {
      throw Error(ErrorCode::kInput,
                  file.string() + ":" + std::to_string(line) +
                      ": is not a weight; give one number from 0 a line, one line per vertex, or x "
                      "y z weight in each line, places within 10 km");
    }
    if (width == 1) {
      muscle.node_weights.push_back(values[0]);
    } else {
      muscle.painted.places.emplace_back(values[0], values[1], values[2]);
      muscle.painted.weights.push_back(values[3]);
    }
  }
  if (width == 0) {
    throw Error(ErrorCode::kInput, file.string() + ": is empty; give one weight a line");
  }
}

ZoneSettings read_zone(TomlValue& table) {
  ZoneSettings zone;
  read(table, "smallest_radius", zone.smallest_radius, kLength);
  read(table, "per_impulse", zone.per_impulse, kNotNegative);
  read(table, "along_load", zone.along_load, kShare);
  read(table, "largest_radius", zone.largest_radius, {zone.smallest_radius, kMaxCoordinate});
  return zone;
}

void read_weights(TomlValue& value, const Folders& folders, SceneMuscle& muscle) {
  if (value.type != TomlValue::Type::kTable) {
    muscle.weights = preset_profile(word_of(value, {"left", "even", "right"}));
    return;
  }
  SceneWeights& painted = muscle.painted;
  read(value, "tolerance", painted.tolerance, kLength);
  if (const TomlValue* colour = find(value, "colour")) {
    const std::vector<std::string> channels = {"red", "green", "blue", "alpha"};
    const std::string& word = word_of(*colour, channels);
    painted.channel =
        static_cast<int>(std::find(channels.begin(), channels.end(), word) - channels.begin());
    if (const TomlValue* file = find(value, "file")) painted.mesh = file_of(*file, folders);
    return;
  }
  const auto [kind, what] = require_one(value, {"profile", "file", "zone"});
  if (kind == "file") read_weight_file(file_of(*what, folders), muscle);
  if (kind == "zone") muscle.zone = read_zone(*what);
  if (kind == "profile") muscle.weights.keys = pairs_of(*what, "[u, weight]", kShare, kNotNegative);
}

// Scaled, then turned, then moved.
Eigen::Affine3d read_transform(TomlValue& table) {
  double scale = 1.0, angle = 0.0;
  Vec3 axis = Vec3::UnitY(), move = Vec3::Zero();
  read(table, "scale", scale, kScale);
  if (TomlValue* given = find(table, "axis")) axis = direction_of(*given);
  read(table, "angle", angle, {-360.0, 360.0});
  read(table, "move", move, kPlace);
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() = scale * rotation_about(axis, angle * kDegree);
  out.translation() = move;
  return out;
}

void read_material(TomlValue& table, SpringMaterial& material) {
  read(table, "young", material.young, kPositive);
  read(table, "anisotropy", material.anisotropy, kPositive);
  read(table, "shear", material.shear, kNotNegative);
  read(table, "bending", material.bending, kNotNegative);
  read(table, "shape", material.shape, kNotNegative);
  read(table, "density", material.density, kPositive);
}

void read_belly(TomlValue& value, std::array<double, 2>& belly) {
  const std::vector<TomlValue>& ends = items_of(value, "metres along the path, [from, to]", 2, 2);
  belly = {number_of(ends[0], kLength), number_of(ends[1], kLength)};
  if (belly[1] <= belly[0]) refuse(ends[1], "give more than " + number_text(belly[0]));
}

// What only a muscle with a path has.
void read_along_path(TomlValue& table, SceneMuscle& muscle) {
  for (TomlValue* wrap : tables_of(table, "wrap")) {
    muscle.wraps.push_back(read_wrap(*wrap, static_cast<int>(muscle.path.size()) - 1));
  }
  if (TomlValue* belly = find(table, "belly")) read_belly(*belly, muscle.belly);
  read(table, "twist_from", muscle.twist_from, kLength);
  std::string shape = "target";
  read(table, "shape", shape, {"target", "weights"});
  muscle.shape = shape == "target" ? SceneMuscle::Shape::kTarget : SceneMuscle::Shape::kWeights;
  read(table, "guide", muscle.guide, kNotNegative);
  read(table, "f_max", muscle.f_max, kNotNegative);
  read(table, "fibre_length", muscle.fibre_length, kSize);
  if (TomlValue* activation = find(table, "activation")) {
    muscle.activation = pairs_of(*activation, "[frame, activation]", kFrames, kShare);
  }
}

// A soft body has no carried shape to be drawn to; it may be held by bodies.
void read_soft_body(TomlValue& table, SceneMuscle& muscle) {
  muscle.shape = SceneMuscle::Shape::kWeights;
  muscle.guide = muscle.damping = muscle.material.shape = 0.0;
  for (TomlValue* fixed : tables_of(table, "fixed")) muscle.fixed.push_back(read_fixed(*fixed));
  if (TomlValue* material = find(table, "material")) {
    if (TomlValue* shape = find(*material, "shape")) {
      if (number_of(*shape, kNotNegative) != 0.0)
        refuse(*shape, "remove it: a body without a path has no carried shape");
    }
  }
}

}  // namespace

SceneMuscle read_muscle(TomlValue& table, const Folders& folders, double size) {
  SceneMuscle muscle;
  muscle.fibre_length *= size;
  muscle.painted.tolerance *= size;
  muscle.location = table.location;
  muscle.name = name_of(require(table, "name"));
  const auto [kind, form] = require_one(table, {"mesh", "profile"});
  if (kind == "mesh") muscle.mesh = file_of(*form, folders);
  if (kind == "mesh") {
    if (TomlValue* location = find(table, "transform"))
      muscle.mesh_place = read_transform(*location);
  }
  if (kind == "profile") read_tube(*form, muscle.profile);
  TomlValue* path = find(table, "path");
  const bool has_path = path || kind == "profile";  // a profile runs along a path
  if (has_path) read_path(path ? *path : require(table, "path"), muscle.path);
  if (has_path) {
    read_along_path(table, muscle);
  } else {
    read_soft_body(table, muscle);
  }
  if (TomlValue* weights = find(table, "weights")) read_weights(*weights, folders, muscle);
  read(table, "damping", muscle.damping, kNotNegative);
  if (TomlValue* material = find(table, "material")) read_material(*material, muscle.material);
  read(table, "colour", muscle.colour, kShare);
  read(table, "zones", muscle.zones, 1, kMaxZones);
  return muscle;
}

}  // namespace thew::sim
