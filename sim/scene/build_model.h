// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/model.h"

namespace thew::sim {

/// Builds the model. Throws Error(kUsage) or Error(kInput), with location, cause and next move,
/// for a definition whose parts do not fit one another.
Model build_model(const ModelDef& def);

}  // namespace thew::sim
