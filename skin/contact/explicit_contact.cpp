// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/explicit_contact.h"

#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"

namespace thew::skin {
namespace {

Touch touch_of(const ContactSolve& solve, const Contact& contact) {
  const Collider& other = solve.colliders[contact.other];
  const Point after = contact_point(solve.colliders, contact);
  const Point before = other.soft ? after : to_point(other.back * to_vec(after));
  const Point normal = to_point(contact.normal);
  return {.normal = normal,
          .from = dot(normal, before) + solve.settings.gap + contact.offset,
          .way = dot(normal, after - before),
          .node = contact.node};
}

}  // namespace

void find_touches(const ContactSolve& solve, const std::vector<Contact>& contacts,
                  Touches& touches) {
  touches.clear();
  for (const Contact& contact : contacts) {
    touches.push_back(touch_of(solve, contact));
    const size_t last = touches.size() - 1;
    if (last > 0 && touches[last - 1].node == contact.node) {  // they come by node
      touches[last - 1].shared = touches[last].shared = true;
    }
  }
}

THEW_VECTORISED
void look_for_near(double t, double frame, double span, const Points& x, const Points& v,
                   Touches& touches, Near& near) {
  near.all.clear();
  near.shared.clear();
  if (touches.empty()) return;
  Point most = {};
  for (const Point& one : v) most = one * one > most ? one * one : most;
  const double fastest = std::sqrt(sum3(most));
  for (Touch& touch : touches) {
    const double open = dot3(touch.normal, x[touch.node]) - touch.from - t * touch.way;
    if (open >= span * (2.0 * fastest + std::abs(touch.way) / frame)) continue;
    near.all.push_back(&touch);
    if (touch.shared) near.shared.push_back(&touch);
  }
  near.held.resize(near.all.size());
}

THEW_VECTORISED
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole, Near& near,
                    const ExplicitNodes& now, VolumeSums& sums) {
  const size_t before = near.holds;
  size_t holds = before;
  double rate = sums.rate, weighted = sums.weighted;  // in registers: each waits for the one before
  for (Touch* touch : near.all) {
    if (touch->held) continue;
    const int i = touch->node;
    const Point n = touch->normal;
    Point v = now.v[i];
    if (lambda != 0.0) v -= lambda * now.direction[i];
    const double open = dot3(n, now.x[i] + h * v) - touch->from - t * touch->way;
    if (open >= 0.0) continue;
    touch->held = true;
    Held& held = near.held[holds++];
    held = {touch, 0.0, -open / h};
    now.v[i] += held.kick * n;
    if (!has_volume) continue;
    const bool stored = whole || touch->shared;
    const double slope = dot3(n, now.gradient[i]);
    held.across = stored ? dot3(n, now.direction[i]) : now.mobility[i] * slope;
    rate += slope * held.kick;
    weighted -= slope * held.across;
    if (stored) now.direction[i] -= held.across * n;
  }
  sums.rate = rate;
  sums.weighted = weighted;
  near.holds = holds;
  return holds > before;
}

// Books what the planes gave: their own kicks, and what they bear of the multiplier's force, given
// back beforehand where advance() goes along all of d.
THEW_VECTORISED
void release_contacts(double lambda, bool whole, const std::vector<double>& mass, Near& near,
                      const ExplicitNodes& now, ContactImpulse& given_in_all) {
  Point impulse = {}, angular = {};
  for (size_t k = 0; k < near.holds; ++k) {
    const auto& [touch, across, kick] = near.held[k];
    const double given = mass[touch->node] * (kick + lambda * across);
    touch->pushed += given;
    if (!whole) now.v[touch->node] += lambda * across * touch->normal;
    const Point push = given * touch->normal;
    impulse += push;
    angular += cross3(now.x[touch->node], push);
    touch->held = false;
  }
  near.holds = 0;
  given_in_all.impulse += to_vec(impulse);
  given_in_all.angular_impulse += to_vec(angular);
}

}  // namespace thew::skin
