// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/read_map.h"

#include <algorithm>

#include "sim/scene/muscle_keys.h"

namespace thew::sim {
namespace {

constexpr std::size_t kMostPlaces = 100000, kMostVertices = 10000000;

void read_places(TomlValue& value, const Range& range, NodeMap& map) {
  for (TomlValue& item : items_of(
           value, "places, [" + std::string(kWeights["places"].form) + ", ...]", 1, kMostPlaces)) {
    const auto& five = items_of(item, "a place, " + std::string(kWeights["places"].form), 5, 5);
    const Range& where = kWeights["places"].range;
    map.places.push_back(
        {Vec3(number_of(five[0], where), number_of(five[1], where), number_of(five[2], where)),
         number_of(five[3], kSize), number_of(five[4], range)});
  }
}

void read_paint(TomlValue& table, const Folders& folders, NodeMap& map) {
  if (const TomlValue* colour = find(table, kWeights["colour"])) {
    const std::string& word = word_of(*colour, kWeights["colour"]);
    const auto& channels = kWeights["colour"].words;
    map.channel =
        static_cast<int>(std::find(channels.begin(), channels.end(), word) - channels.begin());
  }
  if (const TomlValue* attribute = find(table, kWeights["attribute"])) {
    if (map.channel >= 0) refuse(*attribute, "remove it, or the colour");
    map.attribute = text_of(*attribute);
  }
  if (const TomlValue* file = find(table, kWeights["file"])) map.painted = file_of(*file, folders);
  if (TomlValue* scale = find(table, kWeights["scale"])) {
    const auto& two = items_of(*scale, kWeights["scale"].form, 2, 2);
    for (int k = 0; k < 2; ++k) map.scale[k] = number_of(two[k], kWeights["scale"].range);
  }
}

}  // namespace

NodeMap read_map(TomlValue& table, const Key& key, const Folders& folders, double size) {
  const bool of_weights = std::string_view(key.name) == "weights";
  Range range = key.second.most > key.second.least ? key.second : key.range;
  if (of_weights) range = kWeights["profile"].second;
  NodeMap map{.location = table.location, .noun = key.name, .bounds = {range.least, range.most}};
  map.tolerance *= size;
  read(table, kWeights["tolerance"], map.tolerance);
  if (find(table, kWeights["colour"]) || find(table, kWeights["attribute"])) {
    read_paint(table, folders, map);
    return map;
  }
  std::vector<const Key*> ways = {&kWeights["profile"], &kWeights["file"], &kWeights["list"],
                                  &kWeights["places"]};
  const auto [kind, what] = require_one(table, ways);
  if (kind == "file") read_map_file(file_of(*what, folders), map);
  if (kind == "profile") map.keys = pairs_of(*what, kWeights["profile"]);
  if (kind == "places") {
    read_places(*what, range, map);
    map.base = number_of(require(table, kWeights["base"]), range);
  }
  if (kind == "list") {
    for (const TomlValue& item : items_of(*what, kWeights["list"].form, 1, kMostVertices)) {
      map.list.push_back(number_of(item, range));
    }
  }
  return map;
}

void read_number_or_map(TomlValue& table, const Key& key, const Folders& folders, double size,
                        double& number, NodeMap& map) {
  TomlValue* value = find(table, key);
  if (!value) return;
  if (value->type == TomlValue::Type::kTable) {
    map = read_map(*value, key, folders, size);
  } else {
    number = number_of(*value, key.range);
  }
}

}  // namespace thew::sim
