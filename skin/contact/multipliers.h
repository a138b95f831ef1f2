// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// What of a body's contacts goes from step to step: which they are, and what each bears.
struct ContactMotion {
  std::vector<Contact> contacts;          ///< a step to come reads of them which they are
  std::vector<double> normal_multiplier;  ///< by contact: force over the contact stiffness, m
  Points friction_multiplier;             ///< the same along the surface; empty without
};

/// What the contacts of one body are solved with.
struct ContactSolve {
  const std::vector<Collider>& colliders;  ///< all, where they are in this step
  const std::vector<double>& stiffness;    ///< N/m, by node
  const ContactSettings& settings;
  double friction = 0.0;  ///< coefficient
};

/// Whether the other side gives way too, and goes half of the way.
bool is_shared(const std::vector<Collider>& colliders, const Contact& contact);
/// Its point (m) where the other is seen, and where it was when the step began.
Point contact_point(const std::vector<Collider>& colliders, const Contact& contact);
Point contact_point_before(const std::vector<Collider>& colliders, const Contact& contact);
/// Signed gap (m) of a node at x beyond `wanted`.
double contact_gap(const std::vector<Collider>& colliders, const Contact& contact, const Point& x,
                   double wanted);

/// Contacts that go on keep the multipliers that they had `before`, those that hold as one the one
/// that they have.
void keep_multipliers(const ContactMotion& before, bool friction, ContactMotion& now);

/// Moves the nodes that penetrate out along their contacts' normals, which the directions `freed`
/// then leave alone; two that give way share the way, if `with_soft`. True where there was one
/// beyond rounding.
bool push_out(const ContactSolve& solve, const std::vector<Contact>& contacts, bool with_soft,
              std::span<Points> freed, Points& x);

}  // namespace thew::skin
