// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/model_def.h"

namespace thew::tools {

/// The definition `count` times in a row, `apart` (m) along z, in one scene; without its skin.
ModelDef copies_of(const ModelDef& one, int count, double apart);

}  // namespace thew::tools
