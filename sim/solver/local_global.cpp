// SPDX-License-Identifier: Apache-2.0
//
// Implicit Euler by block descent on a prefactored matrix (Liu, Bargteil, O'Brien, Kavan 2013):
// A = M (1/h^2 + damping/h + guide) + (1 + shape) sum k + contact. Each iteration projects the
// springs (local step), solves x = A^-1 f and z = A^-1 W dV/dx in one pass (global step), and goes
// along z to the exact volume. See "Time integration" in sim/method.md.
#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "rig/vectorise.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/step_diagnosis.h"
#include "sim/solver/volume_rule.h"
#include "skin/contact/implicit_contact.h"

namespace thew::sim {
namespace {

// 1/s^2. Draws the nodes of a quasi-static muscle to where its iteration began, so that the matrix
// is definite also for a free body. In the converged shape this force is 0.
constexpr double kNearness = 1.0;

// [x, z] = A^-1 [f, g], in the matrix's order of nodes and back.
THEW_VECTORISED
void solve_pair(const Muscle& muscle, LocalGlobalWork& work, const Points& f, const Points& g,
                Points& x, Points& z) {
  const Skyline& matrix = muscle.stiffness;
  work.pairs.resize(matrix.size());
  x.resize(f.size(), Point{});
  z.resize(f.size(), Point{});
  for (int i = 0; i < matrix.size(); ++i) {
    const int node = matrix.order[i];
    work.pairs[i] = __builtin_shufflevector(f[node], g[node], 0, 1, 2, 3, 4, 5, 6, 7);
  }
  solve(matrix, work.factor, work.pairs);
  for (int i = 0; i < matrix.size(); ++i) {
    const int node = matrix.order[i];
    x[node] = __builtin_shufflevector(work.pairs[i], work.pairs[i], 0, 1, 2, 3);
    z[node] = __builtin_shufflevector(work.pairs[i], work.pairs[i], 4, 5, 6, 7);
  }
}

// A^-1 W dV/dx for the volume before each cut between zones, two in one pass. The last direction,
// of the whole volume, is known.
void solve_zones(const Muscle& muscle, MuscleState& now, LocalGlobalWork& work) {
  std::vector<Points>& gradients = now.volume.zones.gradients;
  std::vector<Points>& directions = now.volume.zone_directions;
  for (Points& gradient : gradients) {
    for (size_t i = 0; i < gradient.size(); ++i) gradient[i] *= now.weights[i];
  }
  directions.resize(gradients.size());
  const size_t cuts = gradients.size() - 1;
  for (size_t c = 0; c < cuts; c += 2) {
    solve_pair(muscle, work, gradients[c], gradients[c + 1], directions[c], directions[c + 1]);
  }
  directions[cuts] = now.volume.direction;
}

THEW_VECTORISED
double dot_of_all(const Points& a, const Points& b) {
  Point sum = {};
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum[0] + sum[1] + sum[2];
}

THEW_VECTORISED
void scale(const std::vector<double>& by, const Points& rows, Points& out) {
  out.resize(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) out[i] = by[i] * rows[i];
}

// The right-hand side's terms of one node alone, N: inertia, drag, guide and gravity.
THEW_VECTORISED
void set_base(const Muscle& muscle, double h, double inertia, double damping, const Point& gravity,
              const MuscleState& now, Points& base) {
  const double drag = damping / h, guide = muscle.settings.guide;
  base.resize(now.x.size());
  for (size_t i = 0; i < now.x.size(); ++i) {
    base[i] = muscle.mass[i] * (inertia * (now.start[i] + h * now.v[i]) + drag * now.start[i] +
                                damping * now.target_velocity[i] + guide * now.target[i] + gravity);
  }
}

}  // namespace

namespace {

// Factors the matrix again only if its diagonal has changed.
void factorise_step(const Model& model, int m, LocalGlobalWork& work) {
  const Muscle& muscle = model.muscles[m];
  if (work.diagonal == work.factored_diagonal) return;
  work.factored_diagonal.clear();  // where factoring fails there is no factor
  if (!factorise(muscle.stiffness, work.diagonal, work.factor)) {
    throw NoSolution(m, "muscle \"" + muscle.name +
                            "\": the step's matrix is not positive definite; check its material "
                            "and time step");
  }
  work.factored_diagonal = work.diagonal;
}

void begin_contacts(const Model& model, int m, double h, State& state, LocalGlobalWork& work) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const ContactSolve solve = contact_solve(model, m, state);
  const bool is_fixed =
      std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end();
  if (!is_fixed && !is_quasi_static(model, m)) {
    guess_flight(solve, now, muscle.mass, to_point(model.gravity), h, now.start, now.v, now.x);
  }
  if (solve.friction > 0.0) find_slip_origins(solve, now.contacts, now.start, work.start_offset);
}

}  // namespace

void begin_local_global(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  LocalGlobalWork& work = work_of<LocalGlobalWork>(now.work);
  const bool still = is_quasi_static(model, m);
  const double guide = muscle.settings.guide, damping = still ? 0.0 : muscle.settings.damping;
  const double inertia = still ? 0.0 : 1.0 / (h * h), drag = damping / h;
  set_base(muscle, h, inertia, damping, to_point(model.gravity), now, work.base);
  const double shape = muscle.settings.material.shape;
  add_ring_edges(muscle.rings, shape, now.target, work.base);
  lengths_by_slot(muscle.rings, now.rest_length, work.rest_by_slot);
  for (const auto& [node, anchor, stiffness] : muscle.anchored) {  // driven nodes are known
    work.base[node] += (1.0 + shape) * stiffness * now.x[anchor];
  }
  const Skyline& matrix = muscle.stiffness;
  work.diagonal.resize(matrix.size());
  for (int i = 0; i < matrix.size(); ++i) {
    work.diagonal[i] = muscle.mass[matrix.order[i]] * (inertia + drag + guide);
    if (still) work.diagonal[i] += kNearness * muscle.mass[matrix.order[i]];
  }
  for (size_t c = 0; c < now.contacts.size(); c = group_end(now.contacts, c)) {
    const int node = now.contacts[c].node;
    work.diagonal[matrix.position[node]] += muscle.contact_stiffness[node];
  }
  factorise_step(model, m, work);
  now.volume.gradient.resize(now.x.size());
  now.volume.direction.resize(now.x.size(), Point{});  // 0 at driven nodes
  begin_contacts(model, m, h, state, work);
  if (muscle.zones.count() > 0) zone_targets(muscle, now.target, now.volume.zone_targets);
}

void iterate_local_global(const Model& model, int m, State& state) {
  const Muscle& muscle = model.muscles[m];
  const VolumeRule& rule = rule_of(model.solver.volume);
  MuscleState& now = state.muscles[m];
  LocalGlobalWork& work = std::get<LocalGlobalWork>(now.work);
  Points &gradient = now.volume.gradient, &direction = now.volume.direction, &f = work.forces;
  now.node_iterations += static_cast<std::int64_t>(now.x.size());
  f = work.base;
  add_ring_projections(muscle.rings, work.rest_by_slot, now.x, f);  // the local step
  if (is_quasi_static(model, m)) {
    for (size_t i = 0; i < f.size(); ++i) f[i] += kNearness * muscle.mass[i] * now.x[i];
  }
  add_contacts(contact_solve(model, m, state), now.x, work.start_offset, now, f);
  volume_gradient(now.x, muscle.rest.triangles, gradient);
  scale(now.weights, gradient, work.weighted);
  const bool zoned = muscle.zones.count() > 0;
  if (zoned) {
    gradients_before(muscle.zones, now.x, muscle.rest.triangles, now.volume.zones.gradients);
  }
  solve_pair(muscle, work, f, work.weighted, now.x, direction);
  // G A^-1 W G^T need not be positive. Even weights, under which it is, then stand in.
  const double along = dot_of_all(gradient, direction);
  double even_along = 0.0;
  if (!(along > 0.0) || rule.wants_even) {
    solve_pair(muscle, work, gradient, gradient, work.unused, work.even);
    even_along = dot_of_all(gradient, work.even);
    if (!(along > 0.0)) {
      direction = work.even;
      ++now.weight_fallbacks;
    }
  }
  if (zoned) {
    solve_zones(muscle, now, work);
    restore_zones(muscle, now);
  }
  rule.restore(muscle, direction, even_along, now.x);
}

}  // namespace thew::sim
