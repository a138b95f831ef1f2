// SPDX-License-Identifier: Apache-2.0
//
// The skin minimises an elastic energy, in which edges keep their rest vectors, rotated with the
// bodies, and anchors draw nodes to the bound shape. Each node stays at or above its rest level of
// the flesh field and slides on it freely.
#include "skin/skin_layer.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "skin/depth.h"
#include "skin/skin_passes.h"

namespace thew::skin {

SkinSettings times(const SkinSettings& settings, double size) {
  SkinSettings out = settings;
  for (double* length : {&out.thickness, &out.fold_gap, &out.bridging, &out.reach}) {
    *length *= size;
  }
  out.lengths = times(out.lengths, size);
  return out;
}

namespace {

// Nodes of no triangle are elastic, and meet nothing.
std::vector<NodeGroup> groups_that_meet(const SkinModel& model, const Bvh& bvh) {
  std::vector<NodeGroup> groups = groups_of(model.surface, bvh);
  for (NodeGroup& group : groups) {
    const auto end = group.nodes.begin() + group.count;
    const auto meets = [&](int node) { return !model.surface.vertex_triangles[node].empty(); };
    group.count = static_cast<int>(std::stable_partition(group.nodes.begin(), end, meets) -
                                   group.nodes.begin());
  }
  std::erase_if(groups, [](const NodeGroup& group) { return group.count == 0; });
  return groups;
}

// Makes the iterations a Chebyshev semi-iteration (Golub, Varga 1961; for meshes Wang 2015): twelve
// then come as near to the balance as a hundred. Alone each leaves of an error a share from 0, of
// what varies from node to node, to almost 1, of what spreads over a limb. More than twelve are
// several semi-iterations, since contacts swing where one goes on.
class SemiIteration {
 public:
  SemiIteration(int iterations, double most) : iterations_(iterations), most_(most) {
    constexpr int kLongest = 12;
    constexpr double kReach = 2.4;  // by trial: with more, what the iterations do not reach swings
    const int parts = (iterations + kLongest - 1) / kLongest;
    length_ = (iterations + parts - 1) / parts;
    largest_ = 1.0 / std::cosh(kReach / length_);
  }

  // Takes x farther than the iteration has, unless it is the last of a semi-iteration.
  void extend(int iteration, SkinState& state) {
    const int at = iteration % length_;
    if (at + 1 == length_ || iteration + 1 == iterations_) return;
    const double square = largest_ * largest_;
    omega_ = at == 0 ? 1.0 : at == 1 ? 2.0 / (2.0 - square) : 4.0 / (4.0 - square * omega_);
    const double step = omega_ * (1.0 + largest_), back = omega_ - 1.0;
    for (size_t i = 0; i < state.x.size(); ++i) {
      const Point begin = state.begun_at[i];
      Point farther = (step - 1.0) * (state.x[i] - begin);
      if (at > 0) farther += back * (begin - state.begun_before[i]);
      state.x[i] += std::min(1.0, most_ / std::max(norm(farther), most_)) * farther;
    }
  }

 private:
  int iterations_, length_;
  double most_;                   // m, so that no node leaves what has been looked up for it
  double largest_, omega_ = 1.0;  // largest_: share of an error, once all are scaled to -l .. l
};

}  // namespace

SkinState initial_skin(const SkinModel& model) {
  const size_t nodes = model.rest.size();
  SkinState state;
  state.x = state.bound = state.elastic = state.stuck = state.searched_at = model.rest;
  state.normals.resize(nodes);
  state.own_normals.resize(nodes);
  state.areas.resize(model.surface.triangles.size());
  find_normals(model, {}, state);
  state.offset.assign(nodes, Point{});
  state.force = state.slip = state.swelling = state.offset;
  state.correction.assign(nodes, 0.0);
  state.room.resize(nodes);
  state.turned.resize(model.neighbours.size());
  state.displaced.resize(nodes);
  state.pulls.resize(nodes);
  state.outward.resize(nodes);
  state.inverse_weight.resize(nodes);
  state.turns.resize(nodes);
  state.planes.planes.resize(nodes);
  state.planes.count.resize(nodes);
  state.solution.resize(nodes);
  state.bvh = build_bvh(model.surface, state.x);
  state.groups = groups_that_meet(model, state.bvh);
  state.walls.assign(nodes, {-1, {}, Vec3::Zero(), 0.0});
  state.normal_boxes.resize(state.bvh.nodes.size());
  return state;
}

void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               const Loop& loop, SkinState& state, double share_of_return, const Props& props) {
  bind_to_pose(model, pose, state);
  find_stuck(model, below, state);
  step_bound_skin(model, below, loop, state, share_of_return, props);
}

void step_bound_skin(const SkinModel& model, const std::vector<Collider>& below, const Loop& loop,
                     SkinState& state, double share_of_return, const Props& props) {
  solve_elastic(model, loop, state);
  predict_skin(model, share_of_return, state);
  SemiIteration semi(model.settings.iterations, model.settings.lengths.lookup_motion);
  for (int iteration = 0; iteration < model.settings.iterations; ++iteration) {
    state.begun_before.swap(state.begun_at);
    state.begun_at = state.x;
    const bool searches = iteration % model.settings.iterations_per_search == 0;
    if (searches) {
      find_normals(model, loop, state);
      find_flesh_below(model, below, iteration == 0, loop, state);
      const double depth = model.settings.lengths.cover_depth;
      find_covers(model, below, depth, depth, iteration == 0, loop, state);
      find_folds(model, loop, state);
    }
    relax(model, loop, searches, state);
    part_folds(model, state);
    cover_triangles(model, 0.0, model.settings.lengths.cover_reach, state);
    semi.extend(iteration, state);
  }
  limit_corrections(model, state);
  cover_flesh(model, below, loop, state);
  untangle(model, below, state);
  store_motion(model,
               state);  // before the volume is restored, which is done anew in each step
  leave_props(props, model.surface, state);
  if (model.settings.keeps_volume) restore_volume(model, below, props, loop, state);
  fit_tree(model.surface, state);
}

void fit_tree(const Surface& surface, SkinState& state) {
  if (same_bytes(state.fitted_at, state.x)) return;
  refit_bvh(surface, state.x, state.bvh);
  state.fitted_at = state.x;
}

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state) {
  SkinMetrics metrics;
  metrics.max_penetration = deepest_inside(below, state.x);
  for (const Collider& flesh : below) {
    metrics.max_poke_through = std::max(
        metrics.max_poke_through, farthest_outside(model.surface, state.bvh, state.x, *flesh.x));
  }
  const auto pairs =
      crossing_triangles(model.surface, state.bvh, state.x, model.surface, state.bvh, state.x);
  metrics.intersecting_pairs = static_cast<int>(pairs.size());
  const double volume = enclosed_volume(state.x, model.surface.triangles);
  metrics.volume_error = std::abs(volume - model.volume) / model.volume;
  return metrics;
}

}  // namespace thew::skin
