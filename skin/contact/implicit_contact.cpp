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
    const double push = solve.stiffness[contact.node] * motion.normal_multiplier[c];
    if (push == 0.0) continue;
    force += push * to_point(contact.normal);
    carried += push * (contact_point(solve.colliders, contact) -
                       contact_point_before(solve.colliders, contact));
    pressed += push;
  }
  for (size_t i = 0; i < x.size(); ++i) {
    whole += mass[i];
    momentum += mass[i] * v[i];
  }
  Point way = h * (1.0 / whole * momentum + h * gravity);
  if (const double size = norm(force); size > 0.0) {
    const Point n = 1.0 / size * force;
    way -= 1.0 / pressed * carried;
    const double blocked = std::max(0.0, -dot(n, way)), slides = norm(across(n, way));
    const double gripped = std::min(solve.friction * blocked, slides);
    if (gripped > 0.0) way -= gripped / slides * across(n, way);
    way += blocked * n + 1.0 / pressed * carried;
  }
  for (size_t i = 0; i < x.size(); ++i) x[i] = start[i] + way;
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
    const size_t end = end_of_one(motion.contacts, c);
    const Point at = x[motion.contacts[c].node];
    size_t nearest = pressing_one(normal, c, end);
    const double before = normal[nearest];
    double open = contact_gap(solve.colliders, motion.contacts[nearest], at, gap);
    for (size_t k = c; k < end; ++k) {
      const double other = contact_gap(solve.colliders, motion.contacts[k], at, gap);
      if (other < open - solve.settings.lengths.nearer) open = other, nearest = k;
    }
    const Contact& contact = motion.contacts[nearest];
    const Point n = to_point(contact.normal);
    std::fill(normal.begin() + c, normal.begin() + end, 0.0);
    normal[nearest] = std::max(0.0, before - open);
    Point to = at + (2.0 * normal[nearest] - before) * n;
    if (friction > 0.0) {
      const Point slip = across(n, at - contact_point(solve.colliders, contact) - apart[nearest]);
      const Point grip_before = across(n, motion.friction_multiplier[c]);
      Point& grip = motion.friction_multiplier[c];
      grip = grip_before - slip;
      const double size = norm(grip), most = friction * normal[nearest];
      if (size > most) grip *= most / size;
      to += 2.0 * grip - grip_before;
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
    const double metres_per_push =
        solve.stiffness[contact.node] * inverse_mass[contact.node] * h * h;
    double& push = motion.normal_multiplier[c];
    const double before = push;
    const double open = contact_gap(solve.colliders, contact, x[contact.node], solve.settings.gap);
    push = std::max(0.0, before - (shared ? 0.5 : 1.0) * open / metres_per_push);
    x[contact.node] += metres_per_push * (push - before) * to_point(contact.normal);
  }
}

}  // namespace thew::skin
