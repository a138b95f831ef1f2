// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene_values.h"

namespace thew {

/// Reads one [[muscle]].
SceneMuscle read_muscle(TomlValue& table, const Folders& folders);

}  // namespace thew
