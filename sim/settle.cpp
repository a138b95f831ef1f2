// SPDX-License-Identifier: Apache-2.0
#include "sim/settle.h"

#include <algorithm>

#include "sim/solver/drive.h"
#include "sim/step.h"

namespace thew::sim {
namespace {

// Mean length of the moves from `before` to `now`, which `moves` then holds, and the sum of their
// products with what it held.
struct Moved {
  double mean = 0.0, along = 0.0;
};
Moved moved_since(const Points& before, const Points& now, Points& moves) {
  Moved out;
  moves.resize(now.size(), Point{});
  for (size_t i = 0; i < now.size(); ++i) {
    const Point move = now[i] - before[i];
    out.mean += norm(move) / static_cast<double>(now.size());
    out.along += dot(move, moves[i]);
    moves[i] = move;
  }
  return out;
}

// m, the farthest that a muscle's node has moved that no body carries. `before` is as moved_since()
// leaves it: the positions now.
double farthest_moved(const Model& model, const State& state, std::vector<Points>& before) {
  double farthest = 0.0;
  before.resize(state.muscles.size());
  for (int m = 0; m < state.count(); ++m) {
    const Points& x = state.muscles[m].x;
    for (size_t i = 0; i < before[m].size(); ++i) {
      if (!model.muscles[m].driven[i]) farthest = std::max(farthest, norm(x[i] - before[m][i]));
    }
    before[m] = x;
  }
  return farthest;
}

}  // namespace

void bring_skin_to_rest(const Model& model, Parallel& parallel, State& state,
                        StageSeconds& seconds) {
  constexpr int kMost = 60;
  constexpr double kLeastShare = 0.02;  // of which nothing swings by itself
  constexpr double kSlow = 0.7;         // of the step before
  double share = kReturnAtRest, moved_before = 1e9;
  if (!model.has_skin) return;
  Points before, moves;
  for (int k = 0; k < kMost; ++k) {
    before = layer_of(model, state).x;
    rest_skin(model, share, parallel, state, seconds);
    const Moved moved = moved_since(before, layer_of(model, state).x, moves);
    if (moved.mean < model.lengths.skin_at_rest) return;
    const bool swings = moved.along < 0.0 && moved.mean > kSlow * moved_before;
    if (swings) share = std::max(0.5 * share, kLeastShare);
    moved_before = moved.mean;
  }
}

int muscles_on_rungs(const State& state) {
  return static_cast<int>(std::count_if(
      state.muscles.begin(), state.muscles.end(),
      [](const MuscleState& muscle) { return muscle.ladder.frame_rung > Rung::kSubsteps; }));
}

Settled settle(const Model& model, Parallel& parallel, State& state,
               const std::function<void()>& on_frame) {
  Settled settled;
  StageSeconds unused;
  const double frame = 1.0 / model.fps, begin = state.time, moves_until = bind_to_first_ends(model);
  std::vector<Points> before;
  farthest_moved(model, state, before);
  while (state.time < -0.5 * frame && !settled.converged) {
    const double time = std::min(0.0, state.time + frame), elapsed = time - state.time;
    step_frame(model, time, parallel, state, unused);
    settled.rungs += muscles_on_rungs(state);
    if (on_frame) on_frame();
    settled.seconds = time - begin;
    // Not by the velocities: a node that each step takes somewhere and contact back has one at
    // rest.
    settled.speed = farthest_moved(model, state, before) / elapsed;
    settled.converged = settled.speed < model.lengths.settled_speed && time >= moves_until;
  }
  state.time = 0.0;
  if (begin < 0.0) bring_skin_to_rest(model, parallel, state, unused);
  return settled;
}

}  // namespace thew::sim
