// SPDX-License-Identifier: Apache-2.0
//
// What the skin encloses keeps its volume by the multiplier of the muscles (Hong et al. 2006, eqs.
// 9 to 14, its cubic solved exactly), where a scene asks for it: [skin] volume = "exact".
#include <algorithm>

#include "muscles/volume.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

// The way of the multiplier: what least stretches the skin for a change of volume, the elastic
// matrix' inverse on dV/dx, each node as freely as it has room.
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

// Along that way to the volume of rest; false where a node would take more than half of its room.
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

}  // namespace

void restore_volume(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  constexpr int kRounds = 10, kPasses = 10;
  look_below(model, below, false, state);
  look_above(model, below, 2.0 * model.settings.lengths.plenty, state);
  state.unswollen = state.x;
  // Where something goes wrong the skin stays as it was, and the rest goes the farther.
  std::vector<char>&held = state.held, &faulty = state.marked;
  held.assign(state.x.size(), 0);
  for (int round = 0; round < kRounds; ++round) {
    for (int pass = 0; pass < kPasses; ++pass) {
      find_room(model, state);
      for (size_t i = 0; i < held.size(); ++i) {
        if (held[i]) state.room[i] = 0.0;
      }
      find_swelling(model, state);
      if (swell(model, state)) break;
    }
    faulty = held;
    find_faults(model, below, state, faulty);
    if (faulty == held) return;
    held = faulty;
    state.x = state.unswollen;
  }
}

}  // namespace thew::skin
