// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/parting.h"

#include "muscles/volume.h"
#include "sim/solver/contacts.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/rungs.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

constexpr double kStep = 0.7;  // of the gap: longer steps overshoot, shorter ones need more rounds
// Most: what a step leaves on the arm takes 6. More would push apart what is not shallow, out of
// the wrong side of a thin muscle or of one that a bone has gone through.
constexpr int kRounds = 8;

void set_body(const Model& model, State& state, int m) {
  begin_parting(state.colliders[m], state.parting.bodies[m]);
  refit_bvh(model.surfaces[m].surface, state.muscles[m].x, state.muscles[m].bvh);
}

// All pairs of colliders whose triangles may cross: each muscle with itself and those after it.
void list_pairs(const Model& model, State& state) {
  PartingWork& work = state.parting;
  work.count = 0;
  const auto add = [&](int a, int b) {
    if (static_cast<size_t>(work.count) == work.pairs.size()) work.pairs.emplace_back();
    work.pairs[work.count].a = a;
    work.pairs[work.count++].b = b;
  };
  for (int m = 0; m < state.count(); ++m) {
    if (!has_forces(state.muscles[m].level)) continue;
    if (model.ignore[m][m] == 0 && !ignores_pair(state, m, m)) add(m, m);
    for (const int other : state.near_pairs.near[m]) {
      const bool twice =
          other < m && has_forces(state.muscles[other].level);  // it has been added as (other, m)
      if (!twice) add(m, other);
    }
  }
}

int find_pairs(Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  parallel.each(work.count, [&](int p) {
    PartingPair& pair = work.pairs[p];
    const bool soft = pair.b < state.count() && has_forces(state.muscles[pair.b].level);
    find_partable(state.colliders[pair.a], work.bodies[pair.a], state.colliders[pair.b],
                  soft ? &work.bodies[pair.b] : nullptr, pair.crossings);
  });
  int crossings = 0;
  for (int p = 0; p < work.count; ++p)
    crossings += static_cast<int>(work.pairs[p].crossings.size());
  return crossings;
}

// Moves what crosses, and gives each muscle that has moved its volume again, along the gradient
// under its weights (eqs 9-14).
void part_once(const Model& model, State& state) {
  PartingWork& work = state.parting;
  for (int p = 0; p < work.count; ++p) {
    PartingPair& pair = work.pairs[p];
    const bool soft = pair.b < state.count() && has_forces(state.muscles[pair.b].level);
    push_apart(state.colliders[pair.a], work.bodies[pair.a], state.colliders[pair.b],
               soft ? &work.bodies[pair.b] : nullptr, pair.crossings,
               kStep * model.contact.settings.gap);
  }
  const bool exact = rule_of(model.solver.volume).exact;
  for (int m = 0; m < state.count(); ++m) {
    MuscleState& now = state.muscles[m];
    const Muscle& muscle = model.muscles[m];
    Parting& body = work.bodies[m];
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (muscle.driven[i]) body.weight[i] = 0.0;
    }
    work.moved[m] = part(body, now.x);
    if (!work.moved[m] || !exact) continue;
    volume_gradient(now.x, muscle.rest.triangles, now.volume.gradient);
    for (size_t i = 0; i < now.x.size(); ++i) now.volume.gradient[i] *= now.weights[i];
    restore_exactly(muscle, now.volume.gradient, now.x);
  }
}

}  // namespace

void part_muscles(const Model& model, Parallel& parallel, State& state) {
  if (!model.contact.enabled) return;
  PartingWork& work = state.parting;
  work.bodies.resize(state.muscles.size());
  work.before.resize(state.muscles.size());
  work.moved.assign(state.muscles.size(), 1);
  list_pairs(model, state);
  for (int round = 0; round <= kRounds; ++round) {
    parallel.each(state.count(), [&](int m) {
      if (work.moved[m]) set_body(model, state, m);
    });
    const bool parted = find_pairs(parallel, state) == 0;
    if (round == 0) {
      if (parted) return;
      for (int m = 0; m < state.count(); ++m) work.before[m] = state.muscles[m].x;
    }
    if (parted) break;
    if (round < kRounds) {
      part_once(model, state);
    } else {
      for (int m = 0; m < state.count(); ++m) std::swap(state.muscles[m].x, work.before[m]);
    }
  }
  for (int m = 0; m < state.count(); ++m) {
    MuscleState& now = state.muscles[m];
    note_volume(model.muscles[m], enclosed_volume(now.x, model.muscles[m].rest.triangles), now);
  }
}

}  // namespace thew::sim
