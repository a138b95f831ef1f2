// SPDX-License-Identifier: Apache-2.0
#include "sim/implicit_contact.h"

#include <algorithm>

#include "sim/fidelity.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

Row across(const Row& n, const Row& d) { return d - dot(n, d) * n; }

Row point_now(const Model& model, const State& state, const Contact& contact) {
  return contact_point(model, contact, other_seen(state, contact));
}

Row point_before(const Model& model, const State& state, const Contact& contact) {
  const int bone = contact.other - state.count();
  if (bone < 0) {
    return contact_point(model, contact, state.muscles[contact.other].start);
  }
  const Row now = point_now(model, state, contact);
  if (state.pose_before.size() != state.pose.size()) return now;  // the first step
  const int body = model.bones[bone].body;
  return to_row(state.pose_before[body] * (state.pose[body].inverse() * to_vec(now)));
}

// Had it no shape: it flies on, and where the step before pressed it on something, goes along with
// that or slides on it, by Coulomb's law. The contacts' stiffness would leave it where it is.
void guess_flight(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  Row force = {}, momentum = {}, carried = {};
  double mass = 0.0, pressed = 0.0;
  for (size_t c = 0; c < now.contacts.size(); ++c) {
    const Contact& contact = now.contacts[c];
    const double push = muscle.contact_stiffness[contact.node] * now.push[c];
    if (push == 0.0) continue;
    force += push * to_row(contact.normal);
    carried += push * (point_now(model, state, contact) - point_before(model, state, contact));
    pressed += push;
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    mass += muscle.mass[i];
    momentum += muscle.mass[i] * now.v[i];
  }
  Row way = h * (1.0 / mass * momentum + h * to_row(model.gravity));
  if (const double size = norm(force); size > 0.0) {
    const Row n = 1.0 / size * force;
    way -= 1.0 / pressed * carried;
    const double blocked = std::max(0.0, -dot(n, way)), slides = norm(across(n, way));
    const double gripped = std::min(model.contact.friction * blocked, slides);
    if (gripped > 0.0) way -= gripped / slides * across(n, way);
    way += blocked * n + 1.0 / pressed * carried;
  }
  for (size_t i = 0; i < now.x.size(); ++i) now.x[i] = now.start[i] + way;
}

}  // namespace

void begin_contacts(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const bool held = std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end();
  if (!held && !is_quasi_static(model, m)) guess_flight(model, m, h, state);
  if (model.contact.friction == 0.0) return;
  now.apart.resize(now.contacts.size());
  for (size_t c = 0; c < now.contacts.size(); ++c) {
    const Contact& contact = now.contacts[c];
    now.apart[c] = now.start[contact.node] - point_before(model, state, contact);
  }
}

void add_contacts(const Model& model, int m, State& state, Rows& f) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const double gap = model.contact.settings.gap, friction = model.contact.friction;
  for (size_t c = 0; c < now.contacts.size();) {
    const size_t end = end_of_one(now.contacts, c);
    const Row x = now.x[now.contacts[c].node];
    size_t nearest = pressing_one(now.push, c, end);
    const double before = now.push[nearest];
    double open = contact_gap(model, state, now.contacts[nearest], x, gap);
    for (size_t k = c; k < end; ++k) {
      const double other = contact_gap(model, state, now.contacts[k], x, gap);
      if (other < open - model.lengths.nearer) open = other, nearest = k;
    }
    const Contact& contact = now.contacts[nearest];
    const Row n = to_row(contact.normal);
    std::fill(now.push.begin() + c, now.push.begin() + end, 0.0);
    now.push[nearest] = std::max(0.0, before - open);
    Row to = x + (2.0 * now.push[nearest] - before) * n;
    if (friction > 0.0) {
      const Row slip = across(n, x - point_now(model, state, contact) - now.apart[nearest]);
      const Row grip_before = across(n, now.grip[c]);
      Row& grip = now.grip[c];
      grip = grip_before - slip;
      const double size = norm(grip), most = friction * now.push[nearest];
      if (size > most) grip *= most / size;
      to += 2.0 * grip - grip_before;
    }
    f[contact.node] += muscle.contact_stiffness[contact.node] * to;
    c = end;
  }
}

}  // namespace thew
