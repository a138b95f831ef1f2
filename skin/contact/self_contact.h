// SPDX-License-Identifier: Apache-2.0
//
// Contact of a soft surface with itself, where it folds: a free node against the nearest triangle
// that faces it.
#pragma once

#include "skin/contact/contact.h"

namespace thew::skin {

/// Adds the contacts of free nodes of collider `mover` with its own triangles to `contacts`, which
/// stay sorted by node, then by collider. A node meets a wall of a fold from outside first, within
/// `margin`. Contacts with penetration are found only for nodes that had a self contact in the step
/// before (`before`: all its contacts, by node), because from the inside all opposite walls look
/// alike. `nearby` is scratch.
void find_self_contacts(const Collider& self, int mover, const ContactSettings& settings,
                        const std::vector<Contact>& before, std::vector<int>& nearby,
                        std::vector<Contact>& contacts);

}  // namespace thew::skin
