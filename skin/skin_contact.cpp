// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "skin/flesh_level.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

constexpr double kSlope = 0.1;   // m/m, most slope of the room along the skin; without it the skin
                                 // looked lumpy (skin/notes.md)
constexpr int kSlopeSweeps = 2;  // pairs of sweeps, forwards and backwards
constexpr int kRounds = 10;      // most rounds of loops that repeat until a condition holds

Vec3 point_of(const SkinModel& model, const SkinState& state, const SkinPlane& plane) {
  const Triangle& t = model.surface.triangles[plane.triangle];
  const auto& b = plane.barycentric;
  return to_vec(b[0] * state.x[t[0]] + b[1] * state.x[t[1]] + b[2] * state.x[t[2]]);
}

double squared(const std::array<double, 3>& b) { return b[0] * b[0] + b[1] * b[1] + b[2] * b[2]; }

void displace(const SkinModel& model, const SkinPlane& plane, const Vec3& by, Points& x) {
  for (int k = 0; k < 3; ++k) {
    x[model.surface.triangles[plane.triangle][k]] += to_point(plane.barycentric[k] * by);
  }
}

void find_flesh_below_node(const SkinModel& model, const std::vector<Collider>& below, int i,
                           SkinState& state) {
  const Lengths& lengths = model.settings.lengths;
  find_flesh(below, state.x, {1, {i}}, lengths.flesh_reach, model.settings.bridging,
             lengths.least_direction, state.hints, state.planes);
  state.searched_at[i] = state.x[i];
}

double moved(const SkinState& state, int i) {
  return to_vec(state.x[i] - state.searched_at[i]).norm();
}

// The flesh at a node that is nearer to it than its least distance, searched for again if the node
// has moved; not `found` if the node is not too near.
FleshValue too_near(const SkinModel& model, const std::vector<Collider>& below, int i,
                    SkinState& state) {
  const auto value = [&](double away) {
    FleshValue flesh = nearest_flesh(state.planes, i, to_vec(state.x[i]));
    flesh.found &= flesh.nearest - away < model.least[i];
    return flesh;
  };
  const double away = moved(state, i);
  FleshValue flesh = value(away);
  if (!flesh.found || away == 0.0) return flesh;
  find_flesh_below_node(model, below, i, state);
  return value(0.0);
}

void leave_flesh_node(const SkinModel& model, const std::vector<Collider>& below, int i,
                      SkinState& state) {
  for (int round = 0; round < kRounds / 2; ++round) {
    FleshValue flesh = too_near(model, below, i, state);
    if (!flesh.found) return;
    const Vec3& gradient = flesh.normal_of_nearest;
    const Vec3 out = outward_direction(gradient, state.normals[i]);
    const double lack = model.least[i] - flesh.nearest + model.settings.lengths.clearance;
    state.x[i] += to_point(climb_distance(gradient, out, lack) * out);
  }
}

// Whether a node of the flesh has come through the skin.
bool is_pierced(const SkinModel& model, const SkinState& state, const SkinPlane& cover) {
  return cover.normal.dot(point_of(model, state, cover)) <
         cover.level - model.settings.lengths.cover;
}

void find_own_crossings(const SkinModel& model, SkinState& state) {
  fit_tree(model.surface, state);
  find_crossings(model.surface, state.bvh, state.x, model.surface, state.bvh, state.x,
                 state.crossings);
  std::erase_if(state.crossings, [&](const std::array<int, 2>& pair) {
    return !model.crosses_at_rest.empty() && model.crosses_at_rest[pair[0]] &&
           model.crosses_at_rest[pair[1]];
  });
  state.crossings_at = state.x;
}

// Marks nodes of crossing triangles and their neighbours.
void mark(const SkinModel& model, const std::vector<std::array<int, 2>>& pairs,
          std::vector<char>& marked) {
  for (const auto& pair : pairs) {
    for (int t : pair) {
      for (int node : model.surface.triangles[t]) {
        marked[node] = 1;
        for (int k = model.first_neighbour[node]; k < model.first_neighbour[node + 1]; ++k) {
          marked[model.neighbours[k]] = 1;
        }
      }
    }
  }
}

void even_out(const SkinModel& model, int i, SkinState& state) {
  Point sum{};
  double weight = 0.0;
  for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
    sum += model.weights[k] * state.x[model.neighbours[k]];
    weight += model.weights[k];
  }
  state.x[i] += 0.5 * (sum * (1.0 / weight) - state.x[i]);
}

// A node of the flesh limits the room of the triangle over it, and smooth_room() that of the skin
// around, less with distance.
void leave_room_over(const SkinModel& model, const SkinPlane& cover, SkinState& state) {
  const Lengths& lengths = model.settings.lengths;
  const Vec3 point = point_of(model, state, cover);
  const double over = std::max(cover.normal.dot(point) - cover.level, 0.0);
  if (over >= lengths.yielding_fat) return;
  const Vec3 flesh = point - (over + lengths.cover) * cover.normal;
  for (const int node : model.surface.triangles[cover.triangle]) {
    const double beside = (to_vec(state.x[node]) - flesh).norm();
    state.room[node] = std::min(state.room[node], over + kSlope * beside);
  }
}

// Limits the growth of the room along the skin to kSlope.
void smooth_room(const SkinModel& model, SkinState& state) {
  bool is_smooth = false;
  for (int sweep = 0; sweep < 2 * kSlopeSweeps && !is_smooth; ++sweep) {
    is_smooth = true;
    for (size_t k = 0; k < state.x.size(); ++k) {
      const size_t i = sweep % 2 == 0 ? k : state.x.size() - 1 - k;
      for (int e = model.first_neighbour[i]; e < model.first_neighbour[i + 1]; ++e) {
        const int j = model.neighbours[e];
        if (state.room[j] >= state.room[i]) continue;
        const double most = state.room[j] + kSlope * norm(state.x[i] - state.x[j]);
        if (most >= state.room[i]) continue;
        state.room[i] = most;
        is_smooth = false;
      }
    }
  }
}

// Walls are told by normals more than 90 degrees apart and by their distance. What lies on the
// brink of either is not moved yet, or a rounding error would decide over millimetres.
double facing(const SkinModel& model, const SkinState& state, const SkinFold& fold) {
  constexpr double kFully = 0.25;  // - cosine, of 104.5 degrees
  Point sum{};
  for (const int node : model.surface.triangles[fold.wall.triangle]) sum += state.normals[node];
  return std::clamp(-dot(sum, state.normals[fold.node]) / (3.0 * kFully), 0.0, 1.0);
}

// Share [1] of a move for what is searched for within `reach` (m).
double brink(double reach, double away) {
  return std::clamp(2.0 * (reach - away) / reach, 0.0, 1.0);
}

}  // namespace

void part_folds(const SkinModel& model, SkinState& state) {
  state.separation.assign(state.x.size(), Point{});
  for (const SkinFold& fold : state.folds) {
    const SkinPlane& wall = fold.wall;
    const Vec3 apart = to_vec(state.x[fold.node]) - point_of(model, state, wall);
    const double lack = wall.level - wall.normal.dot(apart);
    if (lack <= 0.0) continue;
    const double share =
        facing(model, state, fold) * brink(model.settings.lengths.fold_reach, apart.norm());
    const Vec3 by = share * lack / (1.0 + squared(wall.barycentric)) * wall.normal;
    state.separation[fold.node] += to_point(by);
    displace(model, wall, -by, state.separation);
    state.x[fold.node] += to_point(by);
    displace(model, wall, -by, state.x);
  }
}

void cover_triangles(const SkinModel& model, double spared, double reach, SkinState& state) {
  for (const SkinPlane& cover : state.covers) {
    const double lack = cover.level - spared - cover.normal.dot(point_of(model, state, cover));
    if (lack <= 0.0) continue;
    // In the bottom of a fold a triangle would go by three times what it lacks, into the other
    // wall.
    const double by = brink(reach, lack) * lack / squared(cover.barycentric);
    displace(model, cover, std::min(by, model.settings.lengths.max_climb) * cover.normal, state.x);
  }
}

void leave_flesh(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  for (size_t i = 0; i < state.x.size(); ++i)
    leave_flesh_node(model, below, static_cast<int>(i), state);
}

void cover_flesh(const SkinModel& model, const std::vector<Collider>& below, const Loop& loop,
                 SkinState& state) {
  constexpr int kCoverRounds = 4;
  const Lengths& lengths = model.settings.lengths;
  const auto pierced = [&](const SkinPlane& cover) { return is_pierced(model, state, cover); };
  for (int round = 0; round < kCoverRounds; ++round) {
    leave_flesh(model, below, state);
    find_covers(model, below, lengths.cover_depth, 0.0, false, loop, state);
    if (std::none_of(state.covers.begin(), state.covers.end(), pierced)) return;
    // What is pierced by little, and only to where it is not: what is moved then grows from nothing
    // and ends in nothing. With the whole thickness and all that is in reach, one node of the flesh
    // that came through by nothing threw the bottom of a fold elsewhere by 9 mm.
    cover_triangles(model, lengths.cover, lengths.cover_depth, state);
  }
  leave_flesh(model, below, state);
}

void untangle(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  std::vector<char>& marked = state.marked;
  marked.assign(state.x.size(), 0);
  find_own_crossings(model, state);
  for (int round = 0; round < kRounds && !state.crossings.empty(); ++round) {
    const size_t before = state.crossings.size();
    state.untangled = state.x;
    mark(model, state.crossings, marked);
    for (size_t i = 0; i < marked.size(); ++i) {
      if (marked[i]) even_out(model, static_cast<int>(i), state);
    }
    leave_flesh(model, below, state);
    find_own_crossings(model, state);
    if (state.crossings.size() > before) {
      state.x = state.untangled;
      return;
    }
  }
}

void find_room(const SkinModel& model, const Loop& loop, SkinState& state) {
  constexpr int kNodes = 512;  // that a thread takes at a time
  const double plenty = model.settings.lengths.yielding_fat;
  loop.ranges(static_cast<int>(state.x.size()), kNodes, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const FleshValue flesh = nearest_flesh(state.planes, i, to_vec(state.x[i]));
      const double fat = flesh.nearest - model.least[i];
      state.room[i] = flesh.found ? std::clamp(fat, 0.0, plenty) : plenty;
    }
  });
  for (const SkinPlane& cover : state.covers) leave_room_over(model, cover, state);
  smooth_room(model, state);
}

void find_faults(const SkinModel& model, const std::vector<Collider>& below, SkinState& state,
                 std::vector<char>& marked) {
  for (size_t i = 0; i < state.x.size(); ++i) {
    if (too_near(model, below, static_cast<int>(i), state).found) marked[i] = 1;
  }
  for (const SkinPlane& cover : state.covers) {
    if (!is_pierced(model, state, cover)) continue;
    for (int node : model.surface.triangles[cover.triangle]) marked[node] = 1;
  }
  find_own_crossings(model, state);
  mark(model, state.crossings, marked);
}

}  // namespace thew::skin
