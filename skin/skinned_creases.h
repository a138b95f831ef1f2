// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/skinned_skin.h"

namespace thew {

/// Evens out the displacement from `carried` to x where it folds triangles that share an edge by
/// much more than they are folded there: fins, which the elbow's fold raises where neighbours go
/// different ways. What the weights alone fold stays, and a coarse mesh, which cannot enclose the
/// muscles without, stays almost as it is.
void even_creases(const SkinnedSkin& skin, const Rows& carried, Rows& x);

}  // namespace thew
