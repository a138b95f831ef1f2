// SPDX-License-Identifier: Apache-2.0
//
// Contact within an implicit step. By alternating directions: a stiffness in the step's matrix
// draws each node to where it neither penetrates nor slips farther than friction (Coulomb) lets it,
// and the multipliers accumulate over that stiffness. Or one contact after the other, as
// constraints of extended position-based dynamics.
#pragma once

#include "skin/contact/multipliers.h"

namespace thew::skin {

/// A body that nothing holds, had it no shape: it flies on from `start`, and where the step before
/// pressed it on something, goes along with that or slides on it, by Coulomb's law. The contacts'
/// stiffness would leave it where it is. Sets x.
void guess_flight(const ContactSolve& solve, const ContactMotion& motion,
                  const std::vector<double>& mass, const Point& gravity, double h,
                  const Points& start, const Points& v, Points& x);

/// By contact: the node from its point when the step began, m.
void find_slip_origins(const ContactSolve& solve, const std::vector<Contact>& contacts,
                       const Points& start, Points& apart);

/// An iteration's multipliers, and what they add to the right-hand side f, N by node.
void add_contacts(const ContactSolve& solve, const Points& x, const Points& apart,
                  ContactMotion& motion, Points& f);

/// C = gap >= 0, no compliance; a multiplier never pulls. Two soft surfaces share the way. `h` in
/// s.
void project_contacts(const ContactSolve& solve, const std::vector<double>& inverse_mass, double h,
                      ContactMotion& motion, Points& x);

}  // namespace thew::skin
