// SPDX-License-Identifier: Apache-2.0
//
// Contact within an implicit step, in one of two forms. add_contacts(): alternating directions
// (augmented Lagrangian, ADMM). A stiffness in the matrix of the step draws each node to where it
// neither penetrates nor slips farther than Coulomb friction allows, and scaled multipliers
// accumulate over it. project_contacts(): one contact after the other, as constraints of extended
// position-based dynamics.
#pragma once

#include "skin/contact/multipliers.h"

namespace thew::skin {

/// Sets x to a first guess for a body without driven nodes: it moves from `start` as a single point
/// would. It flies on with its momentum under `gravity`, and where contact pressed it in the step
/// before, it moves along with the other surface or slides on it by Coulomb's law. Without the
/// guess the stiffness of the contacts would hold the body back. `h` in s.
void guess_flight(const ContactSolve& solve, const ContactMotion& motion,
                  const std::vector<double>& mass, const Point& gravity, double h,
                  const Points& start, const Points& v, Points& x);

/// Sets `apart` (m) for each contact: node less contact point at the begin of the step.
void find_slip_origins(const ContactSolve& solve, const std::vector<Contact>& contacts,
                       const Points& start, Points& apart);

/// Updates the multipliers in an iteration and adds their forces to the right-hand side f (N, by
/// node).
void add_contacts(const ContactSolve& solve, const Points& x, const Points& apart,
                  ContactMotion& motion, Points& f);

/// Projects each contact as an inequality C = gap >= 0 without compliance (XPBD); multipliers stay
/// non-negative. Two soft surfaces each move half of the distance. `h` in s.
void project_contacts(const ContactSolve& solve, const std::vector<double>& inverse_mass, double h,
                      ContactMotion& motion, Points& x);

}  // namespace thew::skin
