// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/parting.h"

#include <algorithm>

#include "muscles/volume.h"
#include "sim/cache/cache.h"
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
constexpr int kRounds = 12;
// Most rounds in which folds are opened, before: that may make some cross.
constexpr int kUnfolding = 8;
// Of kRounds, those that open what parting folds. More could undo each other's work.
constexpr int kBoth = 2;

bool is_soft(const State& state, int collider) {
  return collider < state.count() && has_forces(state.muscles[collider].level);
}

// Files hold positions in single precision, and what is parted there has to be parted.
void write_positions(const Collider& collider, Points& written) {
  written.resize(collider.x->size());
  for (size_t i = 0; i < written.size(); ++i) {
    for (int k = 0; k < 3; ++k) written[i][k] = as_float((*collider.x)[i][k]);
  }
}

// The trees and written positions of the muscles that were pushed.
void show_pushed(const Model& model, Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  parallel.each(state.count(), [&](int m) {
    if (!work.pushed[m]) return;
    refit_bvh(model.surfaces[m].surface, state.muscles[m].x, state.muscles[m].bvh);
    write_positions(state.colliders[m], work.written[m]);
  });
}

void show_as_written(const Model& model, Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  work.colliders = state.colliders;
  work.written.resize(state.colliders.size());
  for (size_t c = 0; c < work.written.size(); ++c) {
    work.colliders[c].x = &work.written[c];
    if (c >= state.muscles.size()) write_positions(state.colliders[c], work.written[c]);
  }
  work.pushed.assign(state.muscles.size(), 1);
  work.moved = work.pushed;
  show_pushed(model, parallel, state);
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

// Of pairs neither of which has moved since, what was found holds.
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

// The edges of muscles with forces at which they are folded; of what has not moved since they hold.
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

// Moves the muscles that `push_all` pushes; it begins each of them by begin(m). Gives them their
// volume again, along the gradient under their weights (eqs 9-14), and finds where that puts them.
template <typename PushAll>
void move_pushed(const Model& model, Parallel& parallel, State& state, PushAll&& push_all) {
  PartingWork& work = state.parting;
  if (!work.changed) {
    for (int m = 0; m < state.count(); ++m) work.before[m] = state.muscles[m].x;
  }
  work.changed = true;
  std::fill(work.pushed.begin(), work.pushed.end(), 0);
  push_all([&](int m) {
    if (!work.pushed[m]) begin_parting(work.colliders[m], work.bodies[m]);
    work.pushed[m] = work.moved[m] = 1;
  });
  const bool exact = rule_of(model.solver.volume).exact;
  for (int m = 0; m < state.count(); ++m) {
    if (!work.pushed[m]) continue;
    MuscleState& now = state.muscles[m];
    const Muscle& muscle = model.muscles[m];
    part(work.bodies[m], now.x);
    if (!exact) continue;
    volume_gradient(now.x, muscle.rest.triangles, now.volume.gradient);
    for (size_t i = 0; i < now.x.size(); ++i) now.volume.gradient[i] *= now.weights[i];
    restore_exactly(muscle, now.volume.gradient, now.x);
  }
  show_pushed(model, parallel, state);
}

void open_folds(const Model& model, Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  const double longest = kStep * model.contact.settings.gap;
  move_pushed(model, parallel, state, [&](const auto& begin) {
    for (int m = 0; m < state.count(); ++m) {
      const std::vector<FoldedEdge>& edges = work.folds[m].edges;
      if (edges.empty()) continue;
      begin(m);
      push_open(work.colliders[m], model.muscles[m].rest.vertices, edges, longest, work.bodies[m]);
    }
  });
}

void part_crossings(const Model& model, Parallel& parallel, State& state) {
  PartingWork& work = state.parting;
  const double longest = kStep * model.contact.settings.gap;
  move_pushed(model, parallel, state, [&](const auto& begin) {
    for (int p = 0; p < work.count; ++p) {
      const PartingPair& pair = work.pairs[p];
      if (pair.crossings.empty()) continue;
      const bool soft = is_soft(state, pair.b);
      begin(pair.a);
      if (soft) begin(pair.b);
      push_apart(work.colliders[pair.a], work.bodies[pair.a], work.colliders[pair.b],
                 soft ? &work.bodies[pair.b] : nullptr, pair.crossings, longest);
    }
  });
}

// Where they were before: the muscles that still cross something.
void give_up_stuck(State& state) {
  PartingWork& work = state.parting;
  std::vector<char>& stuck = work.pushed;
  std::fill(stuck.begin(), stuck.end(), 0);
  for (int p = 0; p < work.count; ++p) {
    const PartingPair& pair = work.pairs[p];
    if (pair.crossings.empty()) continue;
    stuck[pair.a] = 1;
    if (is_soft(state, pair.b)) stuck[pair.b] = 1;
  }
  for (int m = 0; m < state.count(); ++m) {
    if (stuck[m]) std::swap(state.muscles[m].x, work.before[m]);
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
  work.changed = false;
  list_pairs(model, state);
  show_as_written(model, parallel, state);
  for (int round = 0; round < kUnfolding && find_folds(model, parallel, state) > 0; ++round) {
    open_folds(model, parallel, state);
  }
  for (int round = 0; find_pairs(parallel, state) > 0; ++round) {
    if (round == kRounds) {
      give_up_stuck(state);
      break;
    }
    std::fill(work.moved.begin(), work.moved.end(), 0);
    part_crossings(model, parallel, state);
    if (round < kBoth && find_folds(model, parallel, state) > 0) open_folds(model, parallel, state);
  }
  if (!work.changed) return false;
  for (int m = 0; m < state.count(); ++m) {
    MuscleState& now = state.muscles[m];
    note_volume(model.muscles[m], enclosed_volume(now.x, model.muscles[m].rest.triangles), now);
  }
  return true;
}

}  // namespace thew::sim
