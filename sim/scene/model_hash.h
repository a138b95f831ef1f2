// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/model.h"

namespace thew::sim {

/// Sets the model's hashes, of all that the solver reads; not of pictures, bounds and outputs.
void hash_model(const ModelDef& def, Model& model);

}  // namespace thew::sim
