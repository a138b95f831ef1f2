// SPDX-License-Identifier: Apache-2.0
//
// Extended position-based dynamics (Macklin, Mueller, Chentanez 2016): each spring a constraint
// with compliance 1/k and a multiplier that accumulates over the iterations of a step, so that
// they converge to implicit Euler with the springs' own stiffness. The volume is one such
// constraint.
#include <cmath>

#include "muscles/volume.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/volume_rule.h"
#include "skin/contact/implicit_contact.h"

namespace thew::sim {
namespace {

// The first guess and the inverse mass of each free node. Drag and guide act on one node alone, so
// that their implicit step is exact and needs no multiplier: they are part of the inverse mass.
void predict_freely(const Muscle& muscle, const Point& gravity, double h, MuscleState& now,
                    XpbdWork& work) {
  const double guide = muscle.settings.guide, damping = muscle.settings.damping;
  const double inertia = 1.0 / (h * h), drag = damping / h;
  const double total = inertia + drag + guide;
  work.inverse_mass.assign(now.x.size(), 0.0);
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) continue;  // predict() has put it on its path
    work.inverse_mass[i] = inertia / (muscle.mass[i] * total);
    now.x[i] = (inertia * (now.start[i] + h * now.v[i]) + drag * now.start[i] +
                damping * now.target_velocity[i] + guide * now.target[i] + gravity) *
               (1.0 / total);
  }
}

// Two constraints a spring: C = |d| - L with compliance 1/k, and C = d - t with compliance
// 1/(shape k), where t is the spring's vector in the carried shape.
void project_springs(const Muscle& muscle, MuscleState& now, XpbdWork& work) {
  const Springs& springs = muscle.springs;
  const double shape = muscle.settings.material.shape;
  const double per_step = 1.0 / (work.step * work.step);
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double wa = work.inverse_mass[a], wb = work.inverse_mass[b];
    if (wa + wb == 0.0) continue;
    const double compliance = per_step / springs.stiffness[k];
    Point d = now.x[a] - now.x[b];
    const double length = norm(d);
    if (length > 0.0) {
      double& multiplier = work.length_multiplier[k];
      const double change =
          (now.rest_length[k] - length - compliance * multiplier) / (wa + wb + compliance);
      multiplier += change;
      const Point move = change / length * d;
      now.x[a] += wa * move;
      now.x[b] -= wb * move;
    }
    if (shape == 0.0) continue;
    d = now.x[a] - now.x[b];
    Point& multiplier = work.shape_multiplier[k];
    const Point change = (now.target[a] - now.target[b] - d - compliance / shape * multiplier) *
                         (1.0 / (wa + wb + compliance / shape));
    multiplier += change;
    now.x[a] += wa * change;
    now.x[b] -= wb * change;
  }
}

// C = V - V0, along W dV/dx / m.
void project_volume(const Muscle& muscle, const VolumeRule& rule, MuscleState& now,
                    XpbdWork& work) {
  Points &gradient = now.volume.gradient, &direction = now.volume.direction;
  volume_gradient(now.x, muscle.rest.triangles, gradient);
  double weighted = 0.0, even = 0.0;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Point g = gradient[i];
    const double w = work.inverse_mass[i], squared = dot(g, g);
    direction[i] = w * now.weights[i] * g;
    weighted += w * now.weights[i] * squared;
    even += w * squared;
  }
  const double denominator = rule.wants_even ? even : weighted;
  const double compliance =
      rule.bulk > 0.0 ? volume_compliance(muscle, rule.bulk) / (work.step * work.step) : 0.0;
  if (!(denominator > 0.0)) {
    ++now.unreached;
    return;
  }
  const double error = enclosed_volume(now.x, muscle.rest.triangles) - muscle.rest_volume;
  const double change = -(error + compliance * work.volume_multiplier) / (denominator + compliance);
  work.volume_multiplier += change;
  for (size_t i = 0; i < now.x.size(); ++i) now.x[i] += change * direction[i];
}

}  // namespace

void begin_xpbd(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  XpbdWork& work = work_of<XpbdWork>(now.work);
  work.step = h;
  predict_freely(muscle, to_point(model.gravity), h, now, work);
  work.length_multiplier.assign(muscle.springs.nodes.size(), 0.0);
  work.shape_multiplier.assign(muscle.springs.nodes.size(), Point{});
  work.volume_multiplier = 0.0;
  now.normal_multiplier.assign(now.contacts.size(), 0.0);
  now.volume.direction.assign(now.x.size(), Point{});
  now.volume.gradient.resize(now.x.size());
}

void iterate_xpbd(const Model& model, int m, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  XpbdWork& work = std::get<XpbdWork>(now.work);
  project_springs(muscle, now, work);
  project_contacts(contact_solve(model, m, state), work.inverse_mass, work.step, now, now.x);
  if (model.solver.volume != VolumeMethod::kNone) {
    project_volume(muscle, rule_of(model.solver.volume), now, work);
  }
}

}  // namespace thew::sim
