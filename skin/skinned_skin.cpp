// SPDX-License-Identifier: Apache-2.0
#include "skin/skinned_skin.h"

#include <algorithm>

#include "rig/math.h"

namespace thew {
namespace {

constexpr double kMostWay = 3.0;  // reaches that the skin goes with a muscle against its weights
constexpr double kFlat = 1e-5;    // m, of what the weights leave of a distance: tells no direction
constexpr int kRounds = 20;       // of evening out and of what then has to hold again

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

double squared(const std::array<double, 3>& b) { return b[0] * b[0] + b[1] * b[1] + b[2] * b[2]; }

// Each vertex goes the mean way that is asked for at its points.
struct Asked {
  Rows way;
  std::vector<double> weight;
  explicit Asked(size_t vertices) : way(vertices, Row{}), weight(vertices, 0.0) {}
  void add(const SkinnedSkin::Point& point, const Vec3& by) {
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      way[point.corners[k]] += point.shares[k] * to_row(by);
      weight[point.corners[k]] += point.shares[k];
    }
  }
  void take_mean(Rows& out) const {
    for (size_t i = 0; i < way.size(); ++i) {
      out[i] = weight[i] > 0.0 ? (1.0 / weight[i]) * way[i] : Row{};
    }
  }
};

// The plane over the place of the muscle below a point that the point stays beyond.
struct Wall {
  Vec3 normal = Vec3::Zero();  // unit, from the muscle to the skin as the weights turn it
  double above = 0.0;          // m, of the muscle's place at rest
  double level = 0.0;          // m, of the muscle's place now
  double carried = 0.0;        // m, of the point as the weights have it
  double hold = 0.0;           // 0..1, less where the muscle lies far or has slid away
};

// The point's own offset is turned, and not its corners' with their different weights: of a wide
// triangle they are so much longer that nothing would be left of its direction.
std::vector<Wall> find_walls(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                             const std::vector<Collider>& below, const Rows& x) {
  const double reach = skin.settings.reach;
  std::vector<Affine> of_links;
  link_transforms(skin.weights, bodies, of_links);
  std::vector<Wall> walls(skin.points.size());
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::Point& point = skin.points[p];
    if (point.anchor.muscle < 0) continue;
    Mat3 turn = Mat3::Zero();
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      const int v = point.corners[k];
      const Affine blend = blended_transform(skin.weights, of_links, v);
      turn += point.shares[k] * blend.linear() * skin.from_rest[v];
    }
    Wall& wall = walls[p];
    const Vec3 out = turn * point.anchor.out;
    const double left = out.norm();
    wall.above = point.anchor.out.norm();
    if (left < kFlat) continue;
    wall.normal = out / left;
    const Vec3 now = place_of(point.anchor, below), off = place_of(point, x) - now;
    wall.level = wall.normal.dot(now);
    wall.carried = wall.normal.dot(off) + wall.level;
    const double slid = (off - wall.normal.dot(off) * wall.normal).norm();
    wall.hold = smoothstep(kFlat, 20.0 * kFlat, left) *
                (1.0 - smoothstep(reach, kMostNear * reach, wall.above)) *
                (1.0 - smoothstep(2.0 * reach, 4.0 * reach, slid));
  }
  return walls;
}

void push(const SkinnedSkin::Point& point, const Vec3& by, Rows& x) {
  const Vec3 each = by / squared(point.shares);
  for (int k = 0; k < 3; ++k) x[point.corners[k]] += to_row(point.shares[k] * each);
}

// Out or in with the muscle's place below, against where the weights would have it.
void follow_anchors(const SkinnedSkin& skin, const std::vector<Wall>& walls, SkinState& state) {
  const double most = kMostWay * skin.settings.reach;
  Asked asked(skin.rest.size());
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::Point& point = skin.points[p];
    const Wall& wall = walls[p];
    if (point.share <= 0.0) continue;
    const double way = std::clamp(wall.level + wall.above - wall.carried, -most, most);
    asked.add(point, point.share * wall.hold * way * wall.normal);
  }
  asked.take_mean(state.offset);
}

// Of what the weights alone would make, half its own and half the neighbours' mean, near muscles.
void even_out(const SkinnedSkin& skin, const Rows& carried, SkinState& state) {
  for (size_t i = 0; i < skin.rest.size(); ++i) state.slip[i] = state.x[i] - carried[i];
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
    if (!skin.near[i] || begin == end) continue;
    Row sum{};
    for (int k = begin; k < end; ++k) sum += state.slip[skin.neighbours[k]];
    state.x[i] = carried[i] + 0.5 * state.slip[i] + (0.5 / (end - begin)) * sum;
  }
}

// What the mean of several wishes left behind: as even as it can be with all points beyond theirs.
void stay_beyond(const SkinnedSkin& skin, const std::vector<Wall>& walls, const Rows& carried,
                 SkinState& state) {
  for (int round = 0; round < kRounds; ++round) {
    even_out(skin, carried, state);
    for (size_t p = 0; p < skin.points.size(); ++p) {
      const Wall& wall = walls[p];
      const double whole = wall.level + std::min(wall.above, skin.settings.thickness);
      if (wall.hold <= 0.0 || whole <= wall.carried) continue;
      const double least = wall.carried + wall.hold * (whole - wall.carried);
      const double lack = least - wall.normal.dot(place_of(skin.points[p], state.x));
      if (lack > 0.0) push(skin.points[p], lack * wall.normal, state.x);
    }
  }
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] = state.x[skin.map_back[i]];
}

void look_below(const SkinnedSkin& skin, const std::vector<Collider>& below, double reach,
                SkinState& state) {
  for (size_t p = 0; p < skin.points.size(); ++p) {
    find_flesh(below, place_of(skin.points[p], state.x), reach, skin.settings.bridging,
               static_cast<int>(p), state.hints, state.planes);
  }
}

FleshValue flesh_at(const SkinnedSkin& skin, size_t p, const SkinState& state) {
  return flesh_value(state.planes, static_cast<int>(p), place_of(skin.points[p], state.x),
                     skin.settings.bridging);
}

// 1 where the flesh lies below the skin, 0 where it is that of a fold's other side.
double facing(const FleshValue& flesh, const Wall& wall) {
  const double length = flesh.gradient_of_level.norm();
  if (length < 1e-9 || wall.hold <= 0.0) return 0.0;
  return smoothstep(-0.5, 0.1, flesh.gradient_of_level.dot(wall.normal) / length);
}

// Back to its level over the flesh.
void ride_on_flesh(const SkinnedSkin& skin, const std::vector<Wall>& walls, SkinState& state) {
  const double reach = skin.settings.reach;
  Asked asked(skin.rest.size());
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::Point& point = skin.points[p];
    if (point.share <= 0.0) continue;
    const FleshValue flesh = flesh_at(skin, p, state);
    Vec3 by = Vec3::Zero();
    const double below = flesh.found ? facing(flesh, walls[p]) : 0.0;
    if (below > 0.0) {
      // Flesh that went out of reach lets go.
      const double hold = 1.0 - smoothstep(reach, 2.0 * reach, flesh.nearest);
      const double out = std::clamp(point.level - flesh.level, -reach, reach);
      const double length = std::max(flesh.gradient_of_level.norm(), 0.5);
      by = point.share * below * hold * out / length * flesh.gradient_of_level;
    }
    asked.add(point, by);
  }
  asked.take_mean(state.offset);
}

// Out of the flesh, one point after the other, each by its corners.
void clear_flesh(const SkinnedSkin& skin, const std::vector<Wall>& walls, SkinState& state) {
  constexpr int kSweeps = 2;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (size_t p = 0; p < skin.points.size(); ++p) {
      const SkinnedSkin::Point& point = skin.points[p];
      const FleshValue flesh = flesh_at(skin, p, state);
      if (!flesh.found) continue;
      const double lack = std::min(point.level, skin.settings.thickness) - flesh.level;
      if (lack <= 0.0) continue;
      const double length = std::max(flesh.gradient_of_level.norm(), 0.5);
      push(point, facing(flesh, walls[p]) * lack / length * flesh.gradient_of_level, state.x);
    }
  }
}

void add_smoothed(const SkinnedSkin& skin, int passes, SkinState& state) {
  smooth(skin, passes, state.offset, state.slip);
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] += state.offset[skin.map_back[i]];
}

// What clears the flesh is evened out once, and what that takes back cleared again; no farther than
// what is looked for, lest it leap where a fold leaves no room.
void stay_out_of_flesh(const SkinnedSkin& skin, const std::vector<Wall>& walls,
                       const std::vector<Collider>& below, SkinState& state) {
  for (const int passes : {skin.passes, 0}) {
    look_below(skin, below, skin.settings.thickness + skin.settings.bridging, state);
    Rows before = state.x;
    clear_flesh(skin, walls, state);
    for (size_t i = 0; i < skin.rest.size(); ++i) {
      const Row by = state.x[i] - before[i];
      state.offset[i] = 1.0 / std::max(1.0, norm(by) / skin.settings.bridging) * by;
    }
    state.x.swap(before);
    add_smoothed(skin, passes, state);
  }
}

// The corners of a wide triangle go farther than what they are asked for at a point within.
void keep_near(const SkinnedSkin& skin, const Rows& carried, SkinState& state) {
  const double most = kMostWay * skin.settings.reach;
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    const Row by = state.x[i] - carried[i];
    const double way = norm(by);
    if (way > most) state.x[i] = carried[i] + (most / way) * by;
  }
}

}  // namespace

Vec3 place_of(const SkinnedSkin::Anchor& anchor, const std::vector<Collider>& below) {
  const Collider& muscle = below[anchor.muscle];
  const Triangle& t = muscle.surface->triangles[anchor.triangle];
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 3; ++k) place += anchor.share[k] * to_vec((*muscle.x)[t[k]]);
  return place;
}

Vec3 place_of(const SkinnedSkin::Point& point, const Rows& x) {
  Row place{};
  for (int k = 0; k < 3; ++k) place += point.shares[k] * x[point.corners[k]];
  return to_vec(place);
}

SkinState initial_skinned(const SkinnedSkin& skin) {
  SkinState state;
  state.x = skin.rest;
  state.offset.assign(skin.rest.size(), Row{});
  state.slip = state.offset;
  state.planes.planes.resize(skin.points.size());
  state.planes.count.resize(skin.points.size());
  state.bvh = build_bvh(skin.surface, state.x);
  return state;
}

void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state) {
  state.hints.resize(skin.points.size() * (below.size() + 1), -1);
  skin_vertices(skin.weights, skin.mesh, bodies, state.x);
  const Rows carried = state.x;
  const std::vector<Wall> walls = find_walls(skin, bodies, below, carried);
  follow_anchors(skin, walls, state);
  add_smoothed(skin, skin.first_passes, state);
  stay_beyond(skin, walls, carried, state);
  look_below(skin, below, kMostNear * skin.settings.reach, state);
  ride_on_flesh(skin, walls, state);
  add_smoothed(skin, skin.passes, state);
  stay_out_of_flesh(skin, walls, below, state);
  keep_near(skin, carried, state);
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

double farthest_outside(const SkinnedSkin& skin, const SkinState& state, const Rows& points) {
  constexpr double kFarthest = 0.1;  // m
  double most = 0.0;
  int hint = -1;
  for (const Row& row : points) {
    const Vec3 p = to_vec(row);
    const ClosestPoint near = closest_point(skin.surface, state.bvh, state.x, p, kFarthest, hint);
    hint = near.triangle;
    const double distance = near.triangle < 0 ? kFarthest : near.distance;
    // Outside of the nearest shell it may still be inside of another.
    if (distance > most && winding_number(skin.surface, state.x, p) < 0.5) most = distance;
  }
  return most;
}

}  // namespace thew
