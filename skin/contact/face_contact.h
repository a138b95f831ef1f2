// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// The nodes that are not free (null: none is) and points on the edges between them, some `spacing`
/// (m) apart over the surface at rest, at most 16 on an edge; only where it is so sharp that it
/// slips between the nodes of another: of a radius below five spacings.
std::vector<SurfacePoint> rigid_points(const Surface& surface, const Points& rest,
                                       const std::vector<char>* free_nodes, double spacing);

/// Adds to the contacts of find_contacts() those of the mover's faces with held points of the
/// others: a tendon or an edge of bone slips between the nodes of what is wider, and cannot give
/// way itself. Each free corner of a face takes its share of the way, as a contact of its own; of
/// several with one collider the longest. `memory`: not that of find_contacts().
void find_face_contacts(const std::vector<Collider>& colliders, int mover,
                        const std::vector<int>& near, const ContactSettings& settings,
                        const std::vector<Contact>& pressing, ContactMemory& memory,
                        std::vector<Contact>& contacts);

}  // namespace thew::skin
