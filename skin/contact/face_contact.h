// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// Rigid points of a surface: its nodes that are not free (null: no node is free) and points on the
/// edges between them, about `spacing` (m) apart at rest and at most 16 on an edge. Only where the
/// surface is so sharp that it could slip between the nodes of another: with a radius of curvature
/// below five spacings.
std::vector<SurfacePoint> rigid_points(const Surface& surface, const Points& rest,
                                       const std::vector<char>* free_nodes, double spacing);

/// Adds face contacts to the contacts of find_contacts(): those of faces of the mover with rigid
/// points of the others, because a tendon or an edge of bone would slip between the nodes of a
/// wider surface and cannot give way itself. Each free corner of a face takes its share of the
/// displacement as a contact of its own. `memory` must not be that of find_contacts().
void find_face_contacts(const std::vector<Collider>& colliders, int mover,
                        const std::vector<int>& near, const ContactSettings& settings,
                        const std::vector<Contact>& pressing, ContactMemory& memory,
                        std::vector<Contact>& contacts);

}  // namespace thew::skin
