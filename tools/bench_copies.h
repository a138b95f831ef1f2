// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/model.h"

namespace thew {

/// The model `count` times in a row, `apart` (m) along z, in one scene; without its skin.
Model copies_of(const Model& one, int count, double apart);

}  // namespace thew
