// SPDX-License-Identifier: Apache-2.0
#include "sim/explicit_contact.h"

#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

// To where a body's points were when the step began.
Transform way_back(const State& state, int body) {
  return state.pose_before[body] * state.pose[body].inverse();
}

Touch touch_of(const Model& model, const State& state, const std::vector<Transform>& back,
               const Contact& contact) {
  const Row after = contact_point(model, contact, other_seen(state, contact));
  Row before = after;
  if (contact.other >= state.count()) {
    const int body = model.bones[contact.other - state.count()].body;
    const Transform& move = back[body];
    if (state.body_moved[body]) before = to_row(move.linear() * to_vec(after) + move.translation());
  }
  const Row normal = to_row(contact.normal);
  return {.normal = normal,
          .from = dot(normal, before) + model.contact.settings.gap + contact.offset,
          .way = dot(normal, after - before),
          .node = contact.node};
}

}  // namespace

Touches touches_of(const Model& model, int m, const State& state) {
  Touches touches;
  const std::vector<Contact>& contacts = state.muscles[m].contacts;
  if (contacts.empty()) return touches;
  std::vector<Transform> back;
  for (int b = 0; b < model.skeleton.size(); ++b) back.push_back(way_back(state, b));
  touches.reserve(contacts.size());
  for (const Contact& contact : contacts) {
    touches.push_back(touch_of(model, state, back, contact));
    const size_t last = touches.size() - 1;
    if (last > 0 && touches[last - 1].node == contact.node) {  // they come by node
      touches[last - 1].shared = touches[last].shared = true;
    }
  }
  return touches;
}

THEW_VECTORISED
void look_for_near(double t, double frame, double span, const MuscleState& now, Touches& touches,
                   Near& near) {
  near.all.clear();
  near.shared.clear();
  if (touches.empty()) return;
  Row most = {};
  for (const Row& v : now.v) most = v * v > most ? v * v : most;
  const double fastest = std::sqrt(sum3(most));
  for (Touch& touch : touches) {
    const double open = dot3(touch.normal, now.x[touch.node]) - touch.from - t * touch.way;
    if (open >= span * (2.0 * fastest + std::abs(touch.way) / frame)) continue;
    near.all.push_back(&touch);
    if (touch.shared) near.shared.push_back(&touch);
  }
  near.held.resize(near.all.size());
}

THEW_VECTORISED
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole, Near& near,
                    MuscleState& now, VolumeSums& sums) {
  const size_t before = near.holds;
  size_t holds = before;
  double rate = sums.rate, weighted = sums.weighted;  // in registers: each waits for the one before
  for (Touch* touch : near.all) {
    if (touch->held) continue;
    const int i = touch->node;
    const Row n = touch->normal;
    Row v = now.v[i];
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
void release_contacts(double lambda, bool whole, const Muscle& muscle, Near& near,
                      MuscleState& now) {
  Row impulse = {}, angular = {};
  for (size_t k = 0; k < near.holds; ++k) {
    const auto& [touch, across, kick] = near.held[k];
    const double given = muscle.mass[touch->node] * (kick + lambda * across);
    touch->pushed += given;
    if (!whole) now.v[touch->node] += lambda * across * touch->normal;
    const Row push = given * touch->normal;
    impulse += push;
    angular += cross3(now.x[touch->node], push);
    touch->held = false;
  }
  near.holds = 0;
  now.impulse += to_vec(impulse);
  now.angular_impulse += to_vec(angular);
}

}  // namespace thew
