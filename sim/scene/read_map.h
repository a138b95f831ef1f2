// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/maps/node_map.h"
#include "sim/scene/values.h"

namespace thew::sim {

/// Reads a map, the table of `key`, as muscle_keys.h declares it for weights. The key's last range
/// bounds its values. `size` multiplies lengths that the table does not give.
NodeMap read_map(TomlValue& table, const Key& key, const Folders& folders, double size);

/// The number of a key that takes one, or its map.
void read_number_or_map(TomlValue& table, const Key& key, const Folders& folders, double size,
                        double& number, NodeMap& map);

}  // namespace thew::sim
