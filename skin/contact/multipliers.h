// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// Contacts of a body and the force that each bears; goes from step to step.
struct ContactMotion {
  std::vector<Contact> contacts;  ///< the next step uses them only to find contacts that go on
  std::vector<double> normal_multiplier;  ///< m, by contact: force over the contact stiffness
  Points friction_multiplier;             ///< m, the same along the surface; empty without friction
};

/// Data with which the contacts of one body are solved.
struct ContactSolve {
  const std::vector<Collider>& colliders;  ///< all colliders, in their positions of this step
  const std::vector<double>& stiffness;    ///< N/m, by node
  const ContactSettings& settings;
  double friction = 0.0;  ///< coefficient
};

/// Whether the other surface is soft and moves half of the distance.
bool is_shared(const std::vector<Collider>& colliders, const Contact& contact);
/// The contact point (m) on the other surface: in the previous iterate, and at the begin of the
/// step.
Point contact_point(const std::vector<Collider>& colliders, const Contact& contact);
Point contact_point_before(const std::vector<Collider>& colliders, const Contact& contact);
/// Signed distance (m) of a node at x along the normal, less the gap `wanted` and the offset of the
/// contact.
double contact_gap(const std::vector<Collider>& colliders, const Contact& contact, const Point& x,
                   double wanted);

/// Contacts that go on get their multipliers of the step before; of a group (group_end) the first
/// gets the one that was active.
void keep_multipliers(const ContactMotion& before, bool friction, ContactMotion& now);

/// Moves nodes that penetrate out along the normals of their contacts, and removes these normals
/// from the directions `freed`. Contacts between two soft surfaces take part only if `with_soft`,
/// each side moving half of the distance. True if a node was inside by more than rounding.
bool project_out(const ContactSolve& solve, const std::vector<Contact>& contacts, bool with_soft,
                 std::span<Points> freed, Points& x);

}  // namespace thew::skin
