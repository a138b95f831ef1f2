// SPDX-License-Identifier: Apache-2.0
//
// Contact within an implicit step, by alternating directions: a stiffness in the step's matrix
// draws each node to where it neither penetrates nor slips farther than friction (Coulomb) lets it.
// `push`, out of the surface, and `grip`, along it, are the accumulated multipliers over that
// stiffness.
#pragma once

#include "sim/state.h"

namespace thew {

/// Of a step of h (s): where each contact's node was seen from its point; and the guess of a body
/// that nothing holds, which the forces of the step before move as a whole.
void begin_contacts(const Model& model, int m, double h, State& state);

/// An iteration's multipliers, and what they add to the right-hand side f, N by node.
void add_contacts(const Model& model, int m, State& state, Rows& f);

}  // namespace thew
