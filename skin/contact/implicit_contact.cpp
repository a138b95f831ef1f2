// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/implicit_contact.h"

#include <algorithm>

namespace thew::skin {
namespace {

Point across(const Point& n, const Point& d) { return d - dot(n, d) * n; }

}  // namespace

void guess_flight(const ContactSolve& solve, const ContactMotion& motion,
                  const std::vector<double>& mass, const Point& gravity, double h,
                  const Points& start, const Points& v, Points& x) {
  Point force = {}, momentum = {}, carried = {};
  double whole = 0.0, pressed = 0.0;
  for (size_t c = 0; c < motion.contacts.size(); ++c) {
    const Contact& contact = motion.contacts[c];
    const double force_size = solve.stiffness[contact.node] * motion.normal_multiplier[c];
    if (force_size == 0.0) continue;
    force += force_size * to_point(contact.normal);
    carried += force_size * (contact_point(solve.colliders, contact) -
                             contact_point_before(solve.colliders, contact));
    pressed += force_size;
  }
  for (size_t i = 0; i < x.size(); ++i) {
    whole += mass[i];
    momentum += mass[i] * v[i];
  }
  Point shift = h * (1.0 / whole * momentum + h * gravity);
  if (const double size = norm(force); size > 0.0) {
    const Point n = 1.0 / size * force;
    shift -= 1.0 / pressed * carried;
    const double blocked = std::max(0.0, -dot(n, shift)), slides = norm(across(n, shift));
    const double rubbed = std::min(solve.friction * blocked, slides);
    if (rubbed > 0.0) shift -= rubbed / slides * across(n, shift);
    shift += blocked * n + 1.0 / pressed * carried;
  }
  for (size_t i = 0; i < x.size(); ++i) x[i] = start[i] + shift;
}

void find_slip_origins(const ContactSolve& solve, const std::vector<Contact>& contacts,
                       const Points& start, Points& apart) {
  apart.resize(contacts.size());
  for (size_t c = 0; c < contacts.size(); ++c) {
    apart[c] = start[contacts[c].node] - contact_point_before(solve.colliders, contacts[c]);
  }
}

void add_contacts(const ContactSolve& solve, const Points& x, const Points& apart,
                  ContactMotion& motion, Points& f) {
  const double gap = solve.settings.gap, friction = solve.friction;
  std::vector<double>& normal = motion.normal_multiplier;
  for (size_t c = 0; c < motion.contacts.size();) {
    const size_t end = group_end(motion.contacts, c);
    const Point at = x[motion.contacts[c].node];
    size_t nearest = active_in_group(normal, c, end);
    const double before = normal[nearest];
    double open = contact_gap(solve.colliders, motion.contacts[nearest], at, gap);
    for (size_t k = c; k < end; ++k) {
      const double other = contact_gap(solve.colliders, motion.contacts[k], at, gap);
      if (other < open - solve.settings.lengths.switch_lead) open = other, nearest = k;
    }
    const Contact& contact = motion.contacts[nearest];
    const Point n = to_point(contact.normal);
    std::fill(normal.begin() + c, normal.begin() + end, 0.0);
    normal[nearest] = std::max(0.0, before - open);
    Point to = at + (2.0 * normal[nearest] - before) * n;
    if (friction > 0.0) {
      const Point slip = across(n, at - contact_point(solve.colliders, contact) - apart[nearest]);
      const Point friction_before = across(n, motion.friction_multiplier[c]);
      Point& tangential = motion.friction_multiplier[c];
      tangential = friction_before - slip;
      const double size = norm(tangential), most = friction * normal[nearest];
      if (size > most) tangential *= most / size;
      to += 2.0 * tangential - friction_before;
    }
    f[contact.node] += solve.stiffness[contact.node] * to;
    c = end;
  }
}

void project_contacts(const ContactSolve& solve, const std::vector<double>& inverse_mass, double h,
                      ContactMotion& motion, Points& x) {
  for (size_t c = 0; c < motion.contacts.size(); ++c) {
    const Contact& contact = motion.contacts[c];
    const bool shared = is_shared(solve.colliders, contact);
    const double motion_per_multiplier =
        solve.stiffness[contact.node] * inverse_mass[contact.node] * h * h;
    double& multiplier = motion.normal_multiplier[c];
    const double before = multiplier;
    const double open = contact_gap(solve.colliders, contact, x[contact.node], solve.settings.gap);
    multiplier = std::max(0.0, before - (shared ? 0.5 : 1.0) * open / motion_per_multiplier);
    x[contact.node] += motion_per_multiplier * (multiplier - before) * to_point(contact.normal);
  }
}

}  // namespace thew::skin
