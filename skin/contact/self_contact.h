// SPDX-License-Identifier: Apache-2.0
//
// A soft surface with itself, where it folds: a free node against the nearest triangle that faces
// it from outside.
#pragma once

#include "skin/contact/contact.h"

namespace thew::skin {

/// Adds the contacts of free nodes of `mover` with its own triangles, in their place among
/// `contacts` (by node, then by collider). A node first meets a wall from outside, within `margin`;
/// how deep it is in one is asked only where it met one in the step before (`before`, all
/// contacts of that, by node), since from the inside every opposite wall looks the same. `nearby`
/// is scratch.
void find_self_contacts(const Collider& self, int mover, const ContactSettings& settings,
                        const std::vector<Contact>& before, std::vector<int>& nearby,
                        std::vector<Contact>& contacts);

}  // namespace thew::skin
