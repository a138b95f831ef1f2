// SPDX-License-Identifier: Apache-2.0
//
// Extended position-based dynamics (Macklin, Mueller, Chentanez 2016): each spring a constraint
// with compliance 1/k and a multiplier that accumulates over the iterations of a step, so that what
// they converge to is implicit Euler with the springs' own stiffness. The volume is one such
// constraint.
#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

// Inverse mass of each free node, drag and guide in it: they pull at one node alone, so that their
// implicit step is exact and needs no multiplier.
void predict_freely(const Muscle& muscle, const Row& gravity, double h, MuscleState& now) {
  const double guide = muscle.settings.guide, damping = muscle.settings.damping;
  const double inertia = 1.0 / (h * h), drag = damping / h;
  const double whole = inertia + drag + guide;
  now.inverse_mass.assign(now.x.size(), 0.0);
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) continue;  // predict() has put it on its path
    now.inverse_mass[i] = inertia / (muscle.mass[i] * whole);
    now.x[i] = (inertia * (now.start[i] + h * now.v[i]) + drag * now.start[i] +
                damping * now.target_velocity[i] + guide * now.target[i] + gravity) *
               (1.0 / whole);
  }
}

// C = |d| - L, compliance 1/k; and against leaving the carried shape's edge t, C = d - t,
// compliance 1/(shape k).
void project_springs(const Muscle& muscle, MuscleState& now) {
  const Springs& springs = muscle.springs;
  const double shape = muscle.settings.material.shape;
  const double per_step = 1.0 / (now.step * now.step);
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double wa = now.inverse_mass[a], wb = now.inverse_mass[b];
    if (wa + wb == 0.0) continue;
    const double compliance = per_step / springs.stiffness[k];
    Row d = now.x[a] - now.x[b];
    const double length = norm(d);
    if (length > 0.0) {
      double& multiplier = now.length_multiplier[k];
      const double change =
          (now.rest_length[k] - length - compliance * multiplier) / (wa + wb + compliance);
      multiplier += change;
      const Row move = change / length * d;
      now.x[a] += wa * move;
      now.x[b] -= wb * move;
    }
    if (shape == 0.0) continue;
    d = now.x[a] - now.x[b];
    Row& multiplier = now.shape_multiplier[k];
    const Row change = (now.target[a] - now.target[b] - d - compliance / shape * multiplier) *
                       (1.0 / (wa + wb + compliance / shape));
    multiplier += change;
    now.x[a] += wa * change;
    now.x[b] -= wb * change;
  }
}

// C = V - V0, along W dV/dx / m.
void project_volume(const Model& model, const Muscle& muscle, MuscleState& now) {
  if (model.solver.volume == VolumeMethod::kNone) return;
  volume_gradient(now.x, muscle.rest.triangles, now.gradient);
  double weighted = 0.0, even = 0.0;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Row g = now.gradient[i];
    const double w = now.inverse_mass[i], squared = dot(g, g);
    now.direction[i] = w * now.weights[i] * g;
    weighted += w * now.weights[i] * squared;
    even += w * squared;
  }
  const double denominator = model.solver.volume == VolumeMethod::kPrinted ? even : weighted;
  const double compliance = model.solver.volume == VolumeMethod::kPenalty
                                ? volume_compliance(muscle) / (now.step * now.step)
                                : 0.0;
  if (!(denominator > 0.0)) {
    ++now.unreached;
    return;
  }
  const double error = enclosed_volume(now.x, muscle.rest.triangles) - muscle.rest_volume;
  const double change = -(error + compliance * now.volume_multiplier) / (denominator + compliance);
  now.volume_multiplier += change;
  for (size_t i = 0; i < now.x.size(); ++i) now.x[i] += change * now.direction[i];
}

// C = gap >= 0, no compliance; a push never pulls. Two soft surfaces share the way.
void project_contacts(const Model& model, const Muscle& muscle, State& state, MuscleState& now) {
  const double gap = model.contact.settings.gap;
  for (size_t c = 0; c < now.contacts.size(); ++c) {
    const Contact& contact = now.contacts[c];
    const bool soft = is_shared(model, contact);
    const double metres_per_push = muscle.contact_stiffness[contact.node] *
                                   now.inverse_mass[contact.node] * now.step * now.step;
    const double before = now.push[c];
    const double open = contact_gap(model, state, contact, now.x[contact.node], gap);
    now.push[c] = std::max(0.0, before - (soft ? 0.5 : 1.0) * open / metres_per_push);
    now.x[contact.node] += metres_per_push * (now.push[c] - before) * to_row(contact.normal);
  }
}

}  // namespace

void begin_xpbd(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  now.step = h;
  predict_freely(muscle, to_row(model.gravity), h, now);
  now.length_multiplier.assign(muscle.springs.nodes.size(), 0.0);
  now.shape_multiplier.assign(muscle.springs.nodes.size(), Row{});
  now.volume_multiplier = 0.0;
  now.push.assign(now.contacts.size(), 0.0);
  now.direction.assign(now.x.size(), Row{});
  now.gradient.resize(now.x.size());
}

void iterate_xpbd(const Model& model, int m, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  project_springs(muscle, now);
  project_contacts(model, muscle, state, now);
  project_volume(model, muscle, now);
}

}  // namespace thew
