// SPDX-License-Identifier: Apache-2.0
#include "skin/skinned_skin.h"

#include <algorithm>
#include <set>

#include "rig/math.h"

namespace thew {
namespace {

constexpr double kSmoothed = 0.01;  // m, over which the displacement is evened out
constexpr int kMostPasses = 50;
constexpr int kFewestPasses = 4;     // neighbours may be anchored to muscles that part
constexpr double kFlattened = 1e-6;  // determinant of a blend that has no inverse worth having

void find_neighbours(SkinnedSkin& skin) {
  std::vector<std::set<int>> around(skin.mesh.vertices.size());
  for (const Triangle& t : skin.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = skin.map_back[t[k]], b = skin.map_back[t[(k + 1) % 3]];
      if (a == b) continue;
      around[a].insert(b);
      around[b].insert(a);
    }
  }
  skin.first_neighbour.push_back(0);
  for (const std::set<int>& one : around) {
    skin.neighbours.insert(skin.neighbours.end(), one.begin(), one.end());
    skin.first_neighbour.push_back(static_cast<int>(skin.neighbours.size()));
  }
}

// n passes of half its own, half its neighbours' mean spread a value over e sqrt(n / 2), e the mean
// edge near the muscles: none where the mesh is coarser than that.
int passes_for(const SkinnedSkin& skin) {
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    for (int k = skin.first_neighbour[i]; k < skin.first_neighbour[i + 1]; ++k) {
      if (skin.share[i] <= 0.0) continue;
      sum += to_vec(skin.rest[i] - skin.rest[skin.neighbours[k]]).norm();
      ++count;
    }
  }
  if (count == 0) return 0;
  const double ratio = kSmoothed * count / sum;
  return static_cast<int>(std::min(2.0 * ratio * ratio, 1.0 * kMostPasses));
}

void smooth(const SkinnedSkin& skin, int passes, Rows& push, Rows& before) {
  for (int pass = 0; pass < passes; ++pass) {
    before = push;
    for (size_t i = 0; i < push.size(); ++i) {
      const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      if (begin == end) continue;
      Row sum{};
      for (int k = begin; k < end; ++k) sum += before[skin.neighbours[k]];
      push[i] = 0.5 * before[i] + (0.5 / (end - begin)) * sum;
    }
  }
}

Vec3 place_of(const SkinnedSkin::Anchor& anchor, const std::vector<Collider>& below) {
  const Collider& muscle = below[anchor.muscle];
  const Triangle& t = muscle.surface->triangles[anchor.triangle];
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 3; ++k) place += anchor.share[k] * to_vec((*muscle.x)[t[k]]);
  return place;
}

void bind_anchors(const std::vector<Affine>& rest, const std::vector<Collider>& below,
                  SkinnedSkin& skin) {
  std::vector<Affine> of_links;
  link_transforms(skin.weights, rest, of_links);
  skin.anchors.resize(skin.rest.size());
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    if (skin.map_back[i] != static_cast<int>(i) || skin.share[i] <= 0.0) continue;
    double nearest = skin.settings.reach;
    SkinnedSkin::Anchor& anchor = skin.anchors[i];
    for (size_t m = 0; m < below.size(); ++m) {
      const ClosestPoint near = closest_point(*below[m].surface, *below[m].bvh, *below[m].x,
                                              to_vec(skin.rest[i]), nearest);
      if (near.triangle < 0) continue;
      nearest = std::abs(near.distance);
      anchor.muscle = static_cast<int>(m), anchor.triangle = near.triangle;
      std::copy(near.barycentric, near.barycentric + 3, anchor.share.begin());
    }
    if (anchor.muscle < 0) continue;
    const Affine blend = blended_transform(skin.weights, of_links, static_cast<int>(i));
    if (std::abs(blend.linear().determinant()) < kFlattened) {
      anchor.muscle = -1;
    } else {
      anchor.in_bind = blend.inverse() * place_of(anchor, below);
    }
  }
}

// Out or in with the muscle's place below, against where the weights would have it.
void follow_anchors(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                    const std::vector<Collider>& below, SkinState& state) {
  std::vector<Affine> of_links;
  link_transforms(skin.weights, bodies, of_links);
  const double most = skin.settings.reach;
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    state.offset[i] = Row{};
    const SkinnedSkin::Anchor& anchor = skin.anchors[i];
    if (anchor.muscle < 0) continue;
    const Affine blend = blended_transform(skin.weights, of_links, static_cast<int>(i));
    const Vec3 carried = blend * anchor.in_bind, out = to_vec(state.x[i]) - carried;
    const double length = out.norm();
    if (length < 1e-5) continue;
    const double way = out.dot(place_of(anchor, below) - carried) / length;
    state.offset[i] = to_row(skin.share[i] * std::clamp(way, -most, most) / length * out);
  }
}

void add_smoothed(const SkinnedSkin& skin, int passes, SkinState& state) {
  smooth(skin, passes, state.offset, state.slip);
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] += state.offset[skin.map_back[i]];
}

}  // namespace

SkinnedSkin bind_skinned(const TriMesh& mesh, const std::vector<int>& map_back,
                         const SkinWeights& weights, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, const SkinSettings& settings) {
  SkinnedSkin skin{mesh, weights, map_back, {}, {}, {}, {}, {}, {}, settings, 0};
  skin_vertices(weights, mesh, rest, skin.rest);
  find_neighbours(skin);
  const size_t nodes = skin.rest.size();
  FleshPlanes planes;
  planes.planes.resize(nodes);
  planes.count.resize(nodes);
  std::vector<int> hints(nodes * (below.size() + 1), -1);
  for (size_t i = 0; i < nodes; ++i) {
    const int node = static_cast<int>(i);
    const Vec3 x = to_vec(skin.rest[i]);
    find_flesh(below, x, settings.reach, settings.bridging, node, hints, planes);
    const FleshValue flesh = flesh_value(planes, node, x, settings.bridging);
    skin.level.push_back(flesh.found ? flesh.level : settings.reach);
    skin.share.push_back(
        flesh.found ? 1.0 - smoothstep(0.5 * settings.reach, settings.reach, flesh.nearest) : 0.0);
  }
  bind_anchors(rest, below, skin);
  skin.passes = passes_for(skin);
  return skin;
}

SkinState initial_skinned(const SkinnedSkin& skin) {
  SkinState state;
  state.x = skin.rest;
  state.offset.assign(skin.rest.size(), Row{});
  state.slip = state.offset;
  state.planes.planes.resize(skin.rest.size());
  state.planes.count.resize(skin.rest.size());
  return state;
}

void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state) {
  const SkinSettings& settings = skin.settings;
  skin_vertices(skin.weights, skin.mesh, bodies, state.x);
  follow_anchors(skin, bodies, below, state);
  add_smoothed(skin, std::max(skin.passes, kFewestPasses), state);
  state.hints.resize(skin.rest.size() * (below.size() + 1), -1);
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    state.offset[i] = Row{};
    if (skin.map_back[i] != static_cast<int>(i) || skin.share[i] <= 0.0) continue;
    const int node = static_cast<int>(i);
    const Vec3 x = to_vec(state.x[i]);
    find_flesh(below, x, 2.0 * settings.reach, settings.bridging, node, state.hints, state.planes);
    const FleshValue flesh = flesh_value(state.planes, node, x, settings.bridging);
    if (!flesh.found) continue;
    // Flesh that went out of reach lets go.
    const double hold = 1.0 - smoothstep(settings.reach, 2.0 * settings.reach, flesh.nearest);
    const double out = std::clamp(skin.level[i] - flesh.level, -settings.reach, settings.reach);
    const double length = flesh.gradient_of_level.norm();
    if (length < 1e-9) continue;
    state.offset[i] =
        to_row(skin.share[i] * hold * out / std::max(length, 0.5) * flesh.gradient_of_level);
  }
  add_smoothed(skin, skin.passes, state);
}

double deepest_of(const Rows& points, const std::vector<Collider>& below) {
  constexpr double kDeepest = 0.05;  // m
  double most = 0.0;
  for (const Collider& flesh : below) {
    int hint = -1;
    for (const Row& p : points) {
      const ClosestPoint near =
          closest_point(*flesh.surface, *flesh.bvh, *flesh.x, to_vec(p), kDeepest, hint);
      if (near.triangle < 0) continue;
      hint = near.triangle;
      most = std::max(most, -near.distance);
    }
  }
  return most;
}

}  // namespace thew
