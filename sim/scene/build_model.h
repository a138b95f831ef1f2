// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/model.h"

namespace thew::sim {

/// Builds the model. Error(kUsage, kInput) with place, cause and next move for a definition that
/// does not fit itself.
Model build_model(const ModelDef& def);

}  // namespace thew::sim
