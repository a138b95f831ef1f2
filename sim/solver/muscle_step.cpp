// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/muscle_step.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "muscles/volume.h"
#include "muscles/zone.h"
#include "rig/text.h"
#include "rig/vectorise.h"
#include "sim/solver/step_diagnosis.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

bool has_iterated(const Model& model, int iterations, const State&) {
  if (!model.fidelity) return iterations >= model.solver.iterations;
  const auto& all = model.fidelity->muscles;
  return std::all_of(all.begin(), all.end(),
                     [&](const auto& muscle) { return iterations >= muscle.iterations; });
}

bool has_stepped(const Model&, int iterations, const State&) { return iterations > 0; }

// Iterations go on until no node moves by more than Lengths::converged_motion. NoSolution with
// muscle, time and residual after 10,000. On the way to a frame that is solved by itself they need
// not converge, and a muscle that is pinched there for good may go on swinging a little.
bool has_converged(const Model& model, int iterations, const State& state) {
  constexpr int kMaxIterations = 10000, kMaxAlone = 300;  // the arm converges within 120
  if (!has_iterated(model, iterations, state)) return false;
  const bool alone = state.way.has_value();
  if (model.fidelity || (alone && state.time < 0.0)) return true;
  for (int m = 0; m < state.count(); ++m) {
    const double residual = state.muscles[m].residual;
    if (!has_forces(state.muscles[m].level) || residual <= model.lengths.converged_motion) continue;
    const int most = alone ? kMaxAlone : kMaxIterations;
    if (iterations < most && std::isfinite(residual)) return false;
    if (alone && residual <= model.lengths.pinched_swing) continue;
    char numbers[200];
    std::snprintf(numbers, sizeof numbers,
                  "\" at %.4f s: an iteration still moves a node by %s m after %d of them; let it "
                  "move with inertia, by local_global",
                  std::round(1e4 * state.time) / 1e4 + 0.0,  // not "-0.0000"
                  number_text(residual).c_str(), iterations);
    throw NoSolution(m, "muscle \"" + model.muscles[m].name + numbers);
  }
  return true;
}

// By Integrator.
constexpr IntegratorSteps kSteps[] = {
    {begin_explicit, iterate_explicit, finish_explicit, has_stepped},
    {begin_xpbd, iterate_xpbd, finish_muscle, has_iterated},
    {begin_local_global, iterate_local_global, finish_muscle, has_iterated},
    {begin_local_global, iterate_local_global, finish_muscle, has_converged}};

}  // namespace

const IntegratorSteps& steps_of(Integrator integrator) {
  return kSteps[static_cast<int>(integrator)];
}

THEW_VECTORISED
void predict(const Muscle& muscle, double h, MuscleState& state) {
  state.start = state.x;
  for (size_t i = 0; i < state.x.size(); ++i) {
    state.x[i] = muscle.driven[i] ? state.target[i] : state.start[i] + h * state.target_velocity[i];
  }
}

void update_zone(const Muscle& muscle, double h, MuscleState& state) {
  if (!muscle.settings.zone) return;
  std::vector<int>& loaded = state.volume.deformation_zone.loaded;
  loaded.clear();
  Vec3 load = Vec3::Zero();
  for (size_t c = 0; c < state.contacts.size(); ++c) {
    if (state.normal_multiplier[c] <= 0.0) continue;
    const int node = state.contacts[c].node;
    if (loaded.empty() || loaded.back() != node) loaded.push_back(node);
    load += state.normal_multiplier[c] * muscle.contact_stiffness[node] * state.contacts[c].normal;
  }
  const ZoneSettings& zone = *muscle.settings.zone;
  if (loaded.empty()) {
    state.zone_radius = 0.0;
    state.weights = muscle.weights;
    return;
  }
  const double softness = SpringMaterial{}.stiffness / muscle.settings.material.stiffness;
  state.zone_radius = grown_radius(zone, std::max(state.zone_radius, zone.smallest_radius),
                                   softness * load.norm(), h);
  zone_weights(muscle.zone_links, muscle.rest.vertices, load.normalized(), zone, state.zone_radius,
               state.volume.deformation_zone, state.weights);
  double sum = 0.0;
  for (size_t i = 0; i < state.weights.size(); ++i) {
    if (muscle.driven[i]) state.weights[i] = 0.0;
    sum += state.weights[i];
  }
  if (!(sum > 0.0)) state.weights = muscle.weights;
}

THEW_VECTORISED
void update_previous_iterate(MuscleState& state) {
  state.previous_iterate.resize(state.x.size());
  double squared = 0.0;
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Point d = state.x[i] - state.previous_iterate[i];
    squared = std::max(squared, dot(d, d));
    state.previous_iterate[i] = state.x[i];
  }
  state.residual = std::sqrt(squared);
}

ContactSolve contact_solve(const Model& model, int m, const State& state) {
  return {state.colliders, model.muscles[m].contact_stiffness, model.contact.settings,
          model.contact.friction};
}

void zone_targets(const Muscle& muscle, const Points& target, std::vector<double>& before) {
  before = muscle.zones.rest_before;
  if (!muscle.swells) return;
  volumes_before(muscle.zones, target, muscle.rest.triangles, before);
  const double scale = muscle.rest_volume / before.back();
  for (double& volume : before) volume *= scale;
}

void restore_zones(const Muscle& muscle, MuscleState& now) {
  VolumeWork& work = now.volume;
  now.zone_fallbacks += !restore_zones(muscle.zones, muscle.rest.triangles, work.zone_targets,
                                       work.zone_directions, work.zones, now.x);
}

void note_volume(const Muscle& muscle, double volume, SolverMeasures& measures) {
  measures.volume_error = std::abs(volume / muscle.rest_volume - 1.0);
  measures.substep_volume_error = std::max(measures.substep_volume_error, measures.volume_error);
}

void finish_muscle(const Model& model, int m, double h, State& state) {
  constexpr int kRounds = 30;
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  VolumeWork& work = now.volume;
  const bool exact = rule_of(model.solver.volume).exact;
  const ContactSolve solve = contact_solve(model, m, state);
  // Directions from which the contacts' normals are taken out: of each zone, and last of the whole.
  const bool zoned = !work.zone_directions.empty();
  const std::span<Points> freed =
      zoned ? std::span(work.zone_directions) : std::span(&work.gradient, 1);
  freed.back() = work.direction;
  // In rounds, since restoring the volume moves other nodes into bone. Only in the first push do
  // two soft surfaces each go half of the way.
  bool moves = project_out(solve, now.contacts, true, freed, now.x);
  for (int round = 0; exact && (moves || round == 0) && round < kRounds; ++round) {
    if (zoned) restore_zones(muscle, now);
    if (!restore_exactly(muscle, freed.back(), now.x)) {
      now.unreached += !restore_exactly(muscle, work.direction, now.x);
      moves = false;
      break;
    }
    moves = project_out(solve, now.contacts, false, freed, now.x);
  }
  // A muscle that is pinched between two bodies is pushed for ever: the volume has the last word.
  if (exact && moves) restore_exactly(muscle, work.direction, now.x);
  for (size_t i = 0; i < now.x.size(); ++i) now.v[i] = (now.x[i] - now.start[i]) * (1.0 / h);
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace thew::sim
