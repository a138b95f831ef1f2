// SPDX-License-Identifier: Apache-2.0
//
// If a scene has [skin] volume = "exact", the skin keeps its enclosed volume by the same multiplier
// as the muscles: Hong et al. 2006, eqs 9 to 14, with the cubic solved exactly.
#include <algorithm>

#include "muscles/volume.h"
#include "skin/skin_passes.h"
#include "skin/skin_props.h"

namespace thew::skin {
namespace {

// Sets the direction of the multiplier, R A^-1 R dV/dx, with A the elastic matrix and R the
// diagonal matrix of the room: it stretches the skin least for a change of volume, and each node
// moves in proportion to its room.
void find_swelling(const SkinModel& model, SkinState& state) {
  const std::vector<int>& order = model.matrix.order;
  volume_gradient(state.x, model.surface.triangles, state.swelling);
  for (size_t k = 0; k < order.size(); ++k) {
    const Point g = state.room[order[k]] * state.swelling[order[k]];
    state.solution[k] = PointPair{g[0], g[1], g[2]};
  }
  solve(model.matrix, model.factor, state.solution);
  for (size_t k = 0; k < order.size(); ++k) {
    const PointPair& d = state.solution[k];
    state.swelling[order[k]] = state.room[order[k]] * Point{d[0], d[1], d[2], 0.0};
  }
}

// Moves the skin along that direction to its rest volume. If a node would use more than half of its
// room, the step is shortened and the result is false.
bool swell(const SkinModel& model, SkinState& state) {
  const VolumeCubic cubic = volume_along(state.x, state.swelling, model.surface.triangles);
  const VolumeRoot root = nearest_root(cubic, model.volume);
  double share = 0.0;
  for (size_t i = 0; i < state.x.size(); ++i) {
    if (state.room[i] == 0.0) continue;
    share = std::max(share, std::abs(root.s) * norm(state.swelling[i]) / (0.5 * state.room[i]));
  }
  const double s = root.s / std::max(share, 1.0);
  for (size_t i = 0; i < state.x.size(); ++i) state.x[i] += s * state.swelling[i];
  return root.reached && share <= 1.0;
}

// Restores the volume with the covers that were found. False, and x as it was, if a node has moved
// by more than `most` (m).
bool try_volume(const SkinModel& model, const std::vector<Collider>& below, const Props& props,
                double most, const Loop& loop, SkinState& state) {
  constexpr int kRounds = 10, kPasses = 10;  // chosen by trial
  // Nodes with faults keep their positions from then on, and the others move farther.
  std::vector<char>&frozen = state.frozen, &faulty = state.marked;
  frozen = state.held;
  for (int round = 0; round < kRounds; ++round) {
    for (int pass = 0; pass < kPasses; ++pass) {
      find_room(model, loop, state);
      for (size_t i = 0; i < frozen.size(); ++i) {
        if (frozen[i]) state.room[i] = 0.0;
      }
      find_swelling(model, state);
      const bool is_done = swell(model, state);
      if (largest_distance(state.x, state.unswollen) > most) {
        state.x = state.unswollen;
        return false;
      }
      if (is_done) break;
    }
    faulty = frozen;
    find_faults(model, below, state, faulty);
    mark_at_props(props, state.x, faulty);
    if (faulty == frozen) return true;
    frozen = faulty;
    state.x = state.unswollen;
  }
  return true;
}

// m, by which the skin has to go in the mean.
double way_to_volume(const SkinModel& model, const Points& x) {
  double area = 0.0;
  for (const Triangle& t : model.surface.triangles) {
    area += 0.5 * norm(cross3(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
  }
  return std::abs(model.volume - enclosed_volume(x, model.surface.triangles)) / area;
}

}  // namespace

void restore_volume(const SkinModel& model, const std::vector<Collider>& below, const Props& props,
                    const Loop& loop, SkinState& state) {
  constexpr double kAnywhere = 1e300;
  constexpr double kFarthest = 3.0;  // of the mean way, that some node goes at least; by trial
  const Lengths& lengths = model.settings.lengths;
  find_flesh_below(model, below, false, loop, state);
  state.unswollen = state.x;
  // Flesh that is deeper than this leaves all room that there is (find_room), unless the skin goes
  // down to it by more than `most`.
  const double most = lengths.cover, deep = lengths.yielding_fat + lengths.cover + most;
  if (kFarthest * way_to_volume(model, state.x) < most) {
    find_covers(model, below, deep, 0.0, true, loop, state);
    if (try_volume(model, below, props, most, loop, state)) return;
  }
  find_covers(model, below, 2.0 * lengths.yielding_fat, 0.0, true, loop, state);
  try_volume(model, below, props, kAnywhere, loop, state);
}

}  // namespace thew::skin
