// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/parting.h"

#include <algorithm>

#include "muscles/volume.h"
#include "sim/solver/contacts.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/rungs.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

constexpr double kStep = 0.7;  // of the gap, of a corner at once
// Most: what a step leaves on the arm takes 3. More would push apart what is not shallow, out of
// the wrong side of a thin muscle or of one that a bone has gone through.
constexpr int kRounds = 8;
// Before them, those in which folds are opened as well: that may make something cross.
constexpr int kUnfolding = 8;

bool is_soft(const State& state, int collider) {
  return collider < state.count() && has_forces(state.muscles[collider].level);
}

// Files hold positions in single precision, and what is parted there has to be parted.
void write_positions(const Collider& collider, Points& written) {
  written.resize(collider.x->size());
  for (size_t i = 0; i < written.size(); ++i) {
    for (int k = 0; k < 3; ++k) written[i][k] = static_cast<float>((*collider.x)[i][k]);
  }
}

void show_as_written(State& state) {
  PartingWork& work = state.parting;
  work.colliders = state.colliders;
  work.written.resize(state.colliders.size());
  for (size_t c = 0; c < work.written.size(); ++c) {
    work.colliders[c].x = &work.written[c];
    const bool moves = c < state.muscles.size();  // and is written in each round
    if (!moves) write_positions(state.colliders[c], work.written[c]);
  }
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
      if (other > m || !is_soft(state, other)) add(m, other);  // else it is there as (other, m)
    }
  }
}

// Of pairs neither of which has moved, what was found holds.
int find_pairs(Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  parallel.each(work.count, [&](int p) {
    PartingPair& pair = work.pairs[p];
    if (!work.moved[pair.a] && !(is_soft(state, pair.b) && work.moved[pair.b])) return;
    find_partable(work.colliders[pair.a], work.colliders[pair.b], is_soft(state, pair.b),
                  pair.crossings);
  });
  int crossings = 0;
  for (int p = 0; p < work.count; ++p)
    crossings += static_cast<int>(work.pairs[p].crossings.size());
  return crossings;
}

// The edges of muscles with forces at which they are folded; of what has not moved they hold.
int find_folds(const Model& model, Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  parallel.each(state.count(), [&](int m) {
    if (!work.moved[m]) return;
    work.folds[m].edges.clear();
    if (!has_forces(state.muscles[m].level)) return;
    find_folded_edges(work.colliders[m], model.muscles[m].rest.vertices, work.folds[m]);
  });
  int folds = 0;
  for (const FoldWork& of_muscle : work.folds) folds += static_cast<int>(of_muscle.edges.size());
  return folds;
}

// Moves what crosses or is folded, and gives each muscle that has moved its volume again, along the
// gradient under its weights (eqs 9-14).
void part_once(const Model& model, bool unfolds, State& state) {
  PartingWork& work = state.parting;
  std::fill(work.moved.begin(), work.moved.end(), 0);
  const auto begin = [&](int m) {
    if (!work.moved[m]) begin_parting(work.colliders[m], work.bodies[m]);
    work.moved[m] = 1;
  };
  for (int p = 0; p < work.count; ++p) {
    const PartingPair& pair = work.pairs[p];
    if (pair.crossings.empty()) continue;
    const bool soft = is_soft(state, pair.b);
    begin(pair.a);
    if (soft) begin(pair.b);
    push_apart(work.colliders[pair.a], work.bodies[pair.a], work.colliders[pair.b],
               soft ? &work.bodies[pair.b] : nullptr, pair.crossings,
               kStep * model.contact.settings.gap);
  }
  for (int m = 0; m < state.count() && unfolds; ++m) {
    if (work.folds[m].edges.empty()) continue;
    begin(m);
    push_open(work.colliders[m], model.muscles[m].rest.vertices, work.folds[m].edges,
              kStep * model.contact.settings.gap, work.bodies[m]);
  }
  const bool exact = rule_of(model.solver.volume).exact;
  for (int m = 0; m < state.count(); ++m) {
    if (!work.moved[m]) continue;
    MuscleState& now = state.muscles[m];
    const Muscle& muscle = model.muscles[m];
    part(work.bodies[m], now.x);
    if (!exact) continue;
    volume_gradient(now.x, muscle.rest.triangles, now.volume.gradient);
    for (size_t i = 0; i < now.x.size(); ++i) now.volume.gradient[i] *= now.weights[i];
    restore_exactly(muscle, now.volume.gradient, now.x);
  }
}

// Where they were before: the muscles that still cross something.
void give_up_stuck(State& state) {
  PartingWork& work = state.parting;
  std::fill(work.moved.begin(), work.moved.end(), 0);
  for (int p = 0; p < work.count; ++p) {
    const PartingPair& pair = work.pairs[p];
    if (pair.crossings.empty()) continue;
    work.moved[pair.a] = 1;
    if (is_soft(state, pair.b)) work.moved[pair.b] = 1;
  }
  for (int m = 0; m < state.count(); ++m) {
    if (work.moved[m]) std::swap(state.muscles[m].x, work.before[m]);
  }
}

}  // namespace

bool part_muscles(const Model& model, Parallel& parallel, State& state) {
  // A step is a share of the gap: bodies that keep none are not moved.
  if (!model.contact.enabled || !(model.contact.settings.gap > 0.0)) return false;
  PartingWork& work = state.parting;
  work.bodies.resize(state.muscles.size());
  work.before.resize(state.muscles.size());
  work.folds.resize(state.muscles.size());
  work.moved.assign(state.muscles.size(), 1);
  list_pairs(model, state);
  show_as_written(state);
  for (int round = -kUnfolding; round <= kRounds; ++round) {
    parallel.each(state.count(), [&](int m) {
      if (!work.moved[m]) return;
      refit_bvh(model.surfaces[m].surface, state.muscles[m].x, state.muscles[m].bvh);
      write_positions(state.colliders[m], work.written[m]);
    });
    const bool crosses = find_pairs(parallel, state) > 0, unfolds = round < 0;
    const bool is_folded = unfolds && find_folds(model, parallel, state) > 0;
    if (round == -kUnfolding) {
      if (!crosses && !is_folded) return false;
      for (int m = 0; m < state.count(); ++m) work.before[m] = state.muscles[m].x;
    }
    if (!crosses && !is_folded) break;
    if (round < kRounds) {
      part_once(model, unfolds, state);
    } else {
      give_up_stuck(state);
    }
  }
  for (int m = 0; m < state.count(); ++m) {
    MuscleState& now = state.muscles[m];
    note_volume(model.muscles[m], enclosed_volume(now.x, model.muscles[m].rest.triangles), now);
  }
  return true;
}

}  // namespace thew::sim
