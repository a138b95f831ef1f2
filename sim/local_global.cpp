// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "muscles/volume.h"
#include "rig/vectorise.h"
#include "sim/fidelity.h"
#include "sim/implicit_contact.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

// 1/s^2, of a quasi-static iteration about its own start: keeps the matrix definite where nothing
// holds a body, and leaves the rest where it is.
constexpr double kNearness = 1.0;

// [x, z] = A^-1 [f, W dV/dx], by new index and back.
THEW_VECTORISED
void solve_pair(const Muscle& muscle, MuscleState& now, const Rows& f, const Rows& g, Rows& x,
                Rows& z) {
  const Skyline& matrix = muscle.stiffness;
  now.pairs.resize(matrix.size());
  x.resize(f.size(), Row{});
  z.resize(f.size(), Row{});
  for (int i = 0; i < matrix.size(); ++i) {
    const int node = matrix.order[i];
    now.pairs[i] = __builtin_shufflevector(f[node], g[node], 0, 1, 2, 3, 4, 5, 6, 7);
  }
  solve(matrix, now.factor, now.pairs);
  for (int i = 0; i < matrix.size(); ++i) {
    const int node = matrix.order[i];
    x[node] = __builtin_shufflevector(now.pairs[i], now.pairs[i], 0, 1, 2, 3);
    z[node] = __builtin_shufflevector(now.pairs[i], now.pairs[i], 4, 5, 6, 7);
  }
}

// A^-1 W dL/dx of each cut between zones, two at a time; the last, of the whole, is there already.
void solve_zones(const Muscle& muscle, MuscleState& now) {
  std::vector<Rows>& gradients = now.zone_scratch.gradients;
  for (Rows& gradient : gradients) {
    for (size_t i = 0; i < gradient.size(); ++i) gradient[i] *= now.weights[i];
  }
  now.zone_directions.resize(gradients.size());
  const size_t cuts = gradients.size() - 1;
  for (size_t c = 0; c < cuts; c += 2) {
    solve_pair(muscle, now, gradients[c], gradients[c + 1], now.zone_directions[c],
               now.zone_directions[c + 1]);
  }
  now.zone_directions[cuts] = now.direction;
}

THEW_VECTORISED
double dot(const Rows& a, const Rows& b) {
  Row sum = {};
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum[0] + sum[1] + sum[2];
}

THEW_VECTORISED
void scale(const std::vector<double>& by, const Rows& rows, Rows& out) {
  out.resize(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) out[i] = by[i] * rows[i];
}

// By node: mass times what does not depend on other nodes.
THEW_VECTORISED
void set_base(const Muscle& muscle, double h, double inertia, double damping, const Row& gravity,
              MuscleState& now) {
  const double drag = damping / h, guide = muscle.settings.guide;
  now.base.resize(now.x.size());
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.base[i] =
        muscle.mass[i] * (inertia * (now.start[i] + h * now.v[i]) + drag * now.start[i] +
                          damping * now.target_velocity[i] + guide * now.target[i] + gravity);
  }
}

}  // namespace

void begin_local_global(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const bool still = is_quasi_static(model, m);
  const double guide = muscle.settings.guide, damping = still ? 0.0 : muscle.settings.damping;
  const double inertia = still ? 0.0 : 1.0 / (h * h), drag = damping / h;
  set_base(muscle, h, inertia, damping, to_row(model.gravity), now);
  const double shape = muscle.settings.material.shape;
  add_ring_edges(muscle.rings, shape, now.target, now.base);
  lengths_by_slot(muscle.rings, now.rest_length, now.rest_by_slot);
  for (const auto& [node, anchor, stiffness] : muscle.anchored) {  // goes to the right side
    now.base[node] += (1.0 + shape) * stiffness * now.x[anchor];
  }
  const Skyline& matrix = muscle.stiffness;
  now.diagonal.resize(matrix.size());
  for (int i = 0; i < matrix.size(); ++i) {
    now.diagonal[i] = muscle.mass[matrix.order[i]] * (inertia + drag + guide);
    if (still) now.diagonal[i] += kNearness * muscle.mass[matrix.order[i]];
  }
  for (size_t c = 0; c < now.contacts.size(); c = end_of_one(now.contacts, c)) {
    const int node = now.contacts[c].node;
    now.diagonal[matrix.position[node]] += muscle.contact_stiffness[node];
  }
  if (now.diagonal != now.factored_diagonal) {
    now.factored_diagonal.clear();  // a factor that fails is of no diagonal
    if (!factorise(matrix, now.diagonal, now.factor)) {
      throw Error(ExitCode::kSolver, "muscle \"" + muscle.name +
                                         "\": the step's matrix is not positive definite; check "
                                         "its material and time step");
    }
    now.factored_diagonal = now.diagonal;
  }
  now.gradient.resize(now.x.size());
  now.direction.resize(now.x.size(), Row{});  // where driven it stays 0
  begin_contacts(model, m, h, state);
  if (muscle.zones.count() > 0) zone_targets(muscle, now.target, now.zone_targets);
}

void iterate_local_global(const Model& model, int m, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  now.node_iterations += static_cast<std::int64_t>(now.x.size());
  Rows& f = now.forces;
  f = now.base;
  add_ring_projections(muscle.rings, now.rest_by_slot, now.x, f);  // the local step
  if (is_quasi_static(model, m)) {
    for (size_t i = 0; i < f.size(); ++i) f[i] += kNearness * muscle.mass[i] * now.x[i];
  }
  add_contacts(model, m, state, f);
  volume_gradient(now.x, muscle.rest.triangles, now.gradient);
  scale(now.weights, now.gradient, now.weighted);
  const bool zoned = muscle.zones.count() > 0;
  if (zoned) {
    gradients_before(muscle.zones, now.x, muscle.rest.triangles, now.zone_scratch.gradients);
  }
  solve_pair(muscle, now, f, now.weighted, now.x, now.direction);
  // G A^-1 W G need not be positive: fall back on even weights, under which it is.
  const double along = dot(now.gradient, now.direction);
  double even_along = 0.0;
  if (!(along > 0.0) || model.solver.volume == VolumeMethod::kPrinted) {
    Rows even, unused;
    solve_pair(muscle, now, now.gradient, now.gradient, unused, even);
    even_along = dot(now.gradient, even);
    if (!(along > 0.0)) {
      now.direction = even;
      ++now.weight_fallbacks;
    }
  }
  if (zoned) {
    solve_zones(muscle, now);
    restore_zones(muscle, now);
  }
  restore_volume(muscle, model.solver.volume, now.direction, even_along, now.x);
}

}  // namespace thew
