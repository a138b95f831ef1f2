// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

constexpr double kDashpot = 1e-4;  // s, damping of a spring over its stiffness
constexpr double kMargin = 0.8;    // of the stable step

double dot3(const Row& a, const Row& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void add_damped_spring_forces(const Muscle& muscle, const std::vector<double>& rest_length,
                              const Rows& target, const Rows& x, const Rows& v, Rows& f) {
  const Springs& springs = muscle.springs;
  const double shape = muscle.settings.material.shape;
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const Row d = x[a] - x[b];
    const double length = std::sqrt(dot3(d, d));
    const double rate = dot3(d, v[a] - v[b]) / length;
    const Row force =
        springs.stiffness[k] * ((length - rest_length[k] + kDashpot * rate) / length * d +
                                shape * (d - (target[a] - target[b])));
    f[a] -= force;
    f[b] += force;
  }
}

// Eqs 9-14: lambda from the linearised constraint at the new positions of the driven nodes, W in
// the denominator (method.md, mend 1) except where the printed form is asked for.
void add_multiplier(const Muscle& muscle, VolumeMethod method, double h, MuscleState& now) {
  if (method == VolumeMethod::kNone) return;
  volume_gradient(now.x, muscle.rest.triangles, now.gradient);
  const double volume = enclosed_volume(now.x, muscle.rest.triangles);
  double rate = 0.0, weighted = 0.0, even = 0.0;
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) continue;
    const double squared = dot3(now.gradient[i], now.gradient[i]);
    rate += dot3(now.gradient[i], now.v[i]);
    weighted += squared * now.weights[i] / muscle.mass[i];
    even += squared / muscle.mass[i];
  }
  const double denominator = method == VolumeMethod::kPrinted ? even : weighted;
  if (!(denominator > 0.0)) {
    ++now.unreached;
    return;
  }
  const double lambda = ((volume - muscle.rest_volume) / h + rate) / denominator;  // times h
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.v[i] -= lambda * now.weights[i] / muscle.mass[i] * now.gradient[i];
  }
}

void stop_at_contacts(const Model& model, const State& state, MuscleState& now) {
  const double gap = model.scene.contact.settings.gap;
  for (const Contact& contact : now.contacts) {
    const double open = contact_gap(model, state, contact, now.x[contact.node], gap);
    if (open >= 0.0) continue;
    const Row n = to_row(contact.normal);
    now.x[contact.node] -= open * n;
    now.v[contact.node] -= std::min(0.0, dot3(n, now.v[contact.node])) * n;
  }
}

}  // namespace

int explicit_substeps(const Muscle& muscle, double h) {
  const double omega =
      std::sqrt((1.0 + muscle.settings.material.shape) *
                    highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven) +
                muscle.settings.guide);
  const double zeta = 0.5 * kDashpot * omega;  // damping ratio of the fastest mode
  const double stable = 2.0 / omega * (std::sqrt(1.0 + zeta * zeta) - zeta);
  return std::max(1, static_cast<int>(std::ceil(h / (kMargin * stable))));
}

void step_explicit(const Model& model, int m, double frame, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const int substeps = std::max(model.scene.solver.substeps, explicit_substeps(muscle, frame));
  const double h = frame / substeps;
  const Row gravity = to_row(model.scene.gravity);
  const double guide = muscle.settings.guide, damping = muscle.settings.damping;
  const size_t nodes = now.x.size();
  now.x = now.start;
  std::vector<double> rest_length(now.rest_length.size());
  Rows target(nodes);
  for (int step = 1; step <= substeps; ++step) {
    const double left =
        frame - step * h;  // bones and rest lengths are interpolated inside the frame
    for (size_t k = 0; k < rest_length.size(); ++k) {
      const double t = static_cast<double>(step) / substeps;
      rest_length[k] = now.rest_before[k] + t * (now.rest_length[k] - now.rest_before[k]);
    }
    now.forces.assign(nodes, Row{});
    for (size_t i = 0; i < nodes; ++i) {
      target[i] = now.target[i] - left * now.target_velocity[i];
      if (muscle.driven[i]) {
        now.x[i] = target[i];
        now.v[i] = now.target_velocity[i];
        continue;
      }
      now.forces[i] = muscle.mass[i] * (gravity + guide * (target[i] - now.x[i]) +
                                        damping * (now.target_velocity[i] - now.v[i]));
    }
    add_damped_spring_forces(muscle, rest_length, target, now.x, now.v, now.forces);
    for (size_t i = 0; i < nodes; ++i) {
      if (!muscle.driven[i]) now.v[i] += h / muscle.mass[i] * now.forces[i];
    }
    add_multiplier(muscle, model.volume, h, now);
    for (size_t i = 0; i < nodes; ++i) {
      if (!muscle.driven[i]) now.x[i] += h * now.v[i];
    }
    stop_at_contacts(model, state, now);
    const double volume = enclosed_volume(now.x, muscle.rest.triangles);
    now.substep_volume_error =
        std::max(now.substep_volume_error, std::abs(volume / muscle.rest_volume - 1.0));
  }
  const Rows v = now.v;
  volume_gradient(now.x, muscle.rest.triangles, now.gradient);
  now.direction.resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    now.direction[i] = now.weights[i] / muscle.mass[i] * now.gradient[i];
  }
  finish_muscle(model, m, frame, state);  // exact at the frame's end
  now.v = v;
}

}  // namespace thew
