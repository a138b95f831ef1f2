// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/fit/arm.h"

namespace thew::tools {

/// Whether a `limb` of the `whole`, both as skin_around() gives them, is for the most part of hard
/// pieces (skin::find_hard): a belly that swells does not press them out. `fit` has the axis.
bool is_hard(const TriMesh& whole, const TriMesh& limb, const ArmFit& fit);

/// What of the skin around an arm, and of all, is the arm's own; as skin_around() gives it.
struct OwnSkin {
  TriMesh limb, body;
};
/// fit_girth() to what of the `skin` around an arm and of the `whole` is its own. Where pieces go
/// along its axis from the upper arm to the forearm, others tell nothing of its girth that surround
/// nothing of the axis but what these do: a plate on the shoulder, a bracer, a short sleeve, a
/// weapon. Of several such pieces, as of a body and a jacket, the outermost tells it, or where that
/// is_too_thick() the next one within that is not slender.
OwnSkin fit_own_skin(const ArmTemplate& from, const TriMesh& skin, const TriMesh& whole,
                     ArmFit& fit);

}  // namespace thew::tools
