// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/values.h"

namespace thew::sim {

/// Reads one [[muscle]]. Lengths that it does not give are multiplied by `size`.
SceneMuscle read_muscle(TomlValue& table, const Folders& folders, double size);

}  // namespace thew::sim
