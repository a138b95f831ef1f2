// SPDX-License-Identifier: Apache-2.0
#include "skin/skinned_skin.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "skin/flesh_level.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

constexpr int kRounds = 20;  // of moving divided triangles out; chosen by trial
// Of Lengths::max_climb, that a vertex is moved at most. With 4 muscle stands 10 mm out of a body
// of 8 cm edges at 120 degrees, with 6 it is 5 mm; without a limit an armpit throws spikes of 5 cm.
constexpr double kMostClimbs = 6.0;

Point point_at(const SkinnedSkin::Node& node, const Points& x) {
  Point sum{};
  for (int k = 0; k < 3; ++k) sum += node.shares[k] * x[node.corners[k]];
  return sum;
}

double squared(const std::array<double, 3>& b) { return b[0] * b[0] + b[1] * b[1] + b[2] * b[2]; }

// How each link has turned since the rest pose.
void find_turns(const SkinnedSkin& skin, const std::vector<Affine>& bodies, SkinnedWork& work) {
  work.turns.clear();
  for (const SkinWeights::Link& link : skin.weights.links) {
    const Transform now = rigid_part(bodies[link.body]), rest = rigid_part(skin.bodies[link.body]);
    const Mat3 turn = now.linear() * rest.linear().transpose();
    work.turns.push_back(Eigen::Quaterniond(turn).coeffs());
  }
}

// The bound shape of the layer: positions by the weights and fat, rotations by the blend of the
// links'.
void bind_to_weights(const SkinnedSkin& skin, const SkinnedWork& work, SkinState& layer) {
  for (size_t i = 0; i < skin.nodes.size(); ++i) {
    layer.bound[i] = point_at(skin.nodes[i], work.carried);
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    const Eigen::Vector4d& main = work.turns[skin.carriers[i].front().first];
    for (const auto& [link, share] : skin.carriers[i]) {
      const Eigen::Vector4d& turn = work.turns[link];
      sum += turn.dot(main) < 0.0 ? -share * turn : share * turn;
    }
    const double length = sum.norm();
    layer.turns[i] =
        Eigen::Quaterniond(Eigen::Vector4d(length > 0.0 ? sum / length : main)).toRotationMatrix();
    if (!skin.lift.empty()) layer.bound[i] += to_point(layer.turns[i] * to_vec(skin.lift[i]));
  }
}

// A triangle that was divided is flat, and so cuts off what bulges between its vertices. Moves it
// out over the flesh that the layer has found there. A vertex moves by no more than that flesh has
// moved the layer's own points in its triangles, or by one climb where that is less.
void keep_triangles_out(const SkinnedSkin& skin, const SkinState& layer, SkinnedWork& work,
                        Points& x) {
  work.most.assign(x.size(), 0.0);
  work.before = x;
  for (int round = 0; round < kRounds; ++round) {
    bool is_out = true;
    for (size_t i = 0; i < skin.nodes.size(); ++i) {
      const SkinnedSkin::Node& node = skin.nodes[i];
      if (node.is_vertex()) continue;
      const Vec3 now = to_vec(point_at(node, x));
      const FleshValue flesh = nearest_flesh(layer.planes, static_cast<int>(i), now);
      if (!flesh.found) continue;
      // The layer's own node is out, or as far out as it gets.
      const double cut_off = flesh.normal_of_nearest.dot(to_vec(layer.x[i]) - now);
      const double lack = std::min(skin.layer.least[i] - flesh.nearest, cut_off);
      if (lack <= 0.0) continue;
      is_out = false;
      const double bulge = flesh.normal_of_nearest.dot(to_vec(layer.x[i] - layer.bound[i]));
      const double climb = skin.settings.lengths.max_climb;
      const double farthest = std::clamp(bulge, climb, kMostClimbs * climb);
      const Point by = to_point(lack / squared(node.shares) * flesh.normal_of_nearest);
      for (int k = 0; k < 3; ++k) {
        const int corner = node.corners[k];
        if (node.shares[k] <= 0.0) continue;
        double& most = work.most[corner];
        most = std::max(most, farthest);
        const Point moved = x[corner] + node.shares[k] * by - work.before[corner];
        const double far = norm(moved);
        x[corner] = work.before[corner] + (far > most ? most / far : 1.0) * moved;
      }
    }
    if (is_out) return;
  }
}

}  // namespace

SkinState initial_skinned(const SkinnedSkin& skin) {
  SkinState state;
  state.x = skin.rest;
  state.bvh = build_bvh(skin.surface, state.x);
  return state;
}

SkinState initial_layer(const SkinnedSkin& skin) {
  SkinState layer = initial_skin(skin.layer);
  if (!skin.start.x.empty()) static_cast<SkinMotion&>(layer) = skin.start;
  return layer;
}

void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, const Loop& loop, SkinState& layer,
                  SkinState& state, double share_of_return, const Props& props) {
  SkinnedWork& work = state.skinned;
  link_transforms(skin.weights, bodies, work.of_links);
  skin_by_links(skin.weights, skin.mesh, work.of_links, work.carried);
  state.x = work.carried;
  if (!skin.nodes.empty()) {
    find_turns(skin, bodies, work);
    bind_to_weights(skin, work, layer);
    find_stuck(skin.layer, below, layer);
    step_bound_skin(skin.layer, below, loop, layer, share_of_return);
    for (size_t i = 0; i < skin.nodes.size(); ++i) {
      if (skin.nodes[i].is_vertex() && !skin.nodes[i].is_held)
        state.x[skin.nodes[i].corners[0]] = layer.x[i];
    }
    keep_triangles_out(skin, layer, work, state.x);
  }
  leave_props(props, skin.surface, state);
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] = state.x[skin.map_back[i]];
}

}  // namespace thew::skin
