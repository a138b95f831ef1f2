// SPDX-License-Identifier: Apache-2.0
//
// Sweeps over the nodes of the skin. Each node waits for the one before, but only with the sum over
// its neighbours: what depends on its own position alone is computed before the sweep, of four
// nodes at a time.
#include <algorithm>
#include <cmath>

#include "muscles/lanes.h"
#include "rig/vectorise.h"
#include "skin/flesh_level.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

// Weight of the pull of the flesh on skin above its level; chosen by trial.
constexpr double kInwardPull = 0.05;

// Sets `pulls` of a node: the weight of the pull of the flesh on it, which is returned, times the
// displacement that it asks for.
double find_pull(const SkinModel& model, int i, SkinState& state) {
  const FleshPlanes::Plane* near = state.planes.planes[i].data();
  const double bridging = model.settings.bridging, fat = model.fat[i];
  FleshLevel level;
  find_level(near, state.planes.count[i], to_vec(state.x[i]), bridging, level);
  state.pulls[i] = Point{};
  if (level.active == 0 || !(level.level > fat)) return 0.0;
  const Vec3 gradient = gradient_of(near, level, bridging);
  const Vec3 out = outward_direction(gradient, state.normals[i]);
  const double step = climb_distance(gradient, out, fat - level.level);
  const double pull = kInwardPull * std::max(1.0 + step / model.settings.lengths.pull_range, 0.0);
  state.pulls[i] = pull * (state.x[i] + to_point(step * out) - state.elastic[i]);
  return pull;
}

[[gnu::always_inline]] inline Lanes at_least(const Lanes& a, double least) {
  const Lanes bound = Lanes{} + least;
  return a < bound ? bound : a;
}

// In the order in which Eigen sums.
[[gnu::always_inline]] inline Lanes sum_of(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}

[[gnu::always_inline]] inline Point plane_of(const FleshPlanes& planes, int node, int k) {
  const FleshPlanes::Plane& plane = planes.planes[node][k];
  return Point{plane.normal[0], plane.normal[1], plane.normal[2], plane.offset};
}

[[gnu::always_inline]] inline bool any(const decltype(Lanes{} < Lanes{}) & lanes) {
  return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0;
}

using Mask = decltype(Lanes{} < Lanes{});

// outward_direction(), and what climb_distance() divides by.
[[gnu::always_inline]] inline void find_outward(const Lanes3& gradient, const Lanes3& normal,
                                                Lanes3& out, Lanes& along) {
  out = {gradient.x + kNormalShare * normal.x, gradient.y + kNormalShare * normal.y,
         gradient.z + kNormalShare * normal.z};
  const Lanes length = root(sum_of(out, out));
  const Mask has_length = length > 0.0;
  out.x = has_length ? out.x / length : normal.x;
  out.y = has_length ? out.y / length : normal.y;
  out.z = has_length ? out.z / length : normal.z;
  along = at_least(sum_of(gradient, out), kLeastAlong);
}

[[gnu::always_inline]] inline void find_pull(const SkinModel& model, const Lanes3& x,
                                             const Lanes3& elastic, const Lanes3& out,
                                             const Lanes& step, const Mask& is_pulled,
                                             Lanes& weight, Lanes3& by) {
  const Lanes zero = {};
  const Lanes pull = kInwardPull * at_least(1.0 + step / model.settings.lengths.pull_range, 0.0);
  weight = is_pulled ? pull : zero;
  by.x = is_pulled ? pull * (x.x + step * out.x - elastic.x) : zero;
  by.y = is_pulled ? pull * (x.y + step * out.y - elastic.y) : zero;
  by.z = is_pulled ? pull * (x.z + step * out.z - elastic.z) : zero;
}

// find_pull() of four nodes, with the same bytes. It goes through the planes in the order in which
// they are, by their distance when they were found. Nodes of which that is no longer the order are
// told in `unordered`.
[[gnu::always_inline]] inline void find_four_pulls(const SkinModel& model, const SkinState& state,
                                                   const int* node, int most, Lanes& weight,
                                                   Lanes3& by, bool* unordered) {
  constexpr int kMost = FleshPlanes::kMaxPlanes;
  const Lanes zero = {};
  const double bridging = model.settings.bridging;
  const Lanes3 x = gather(state.x.data(), node), elastic = gather(state.elastic.data(), node);
  const Lanes3 normal = gather(state.normals.data(), node);
  Lanes fat = {}, count = {};
  for (int l = 0; l < kLanes; ++l) {
    fat[l] = model.fat[node[l]];
    count[l] = state.planes.count[node[l]];
  }
  Lanes3 normals[kMost];
  Lanes away[kMost], s1 = {}, s2 = {}, f = {};
  Mask active[kMost], is_out_of_order = {};
  int last = 0;
  for (int k = 0; k < most; ++k) {
    const Point a = plane_of(state.planes, node[0], k), b = plane_of(state.planes, node[1], k);
    const Point c = plane_of(state.planes, node[2], k), d = plane_of(state.planes, node[3], k);
    normals[k] = side_by_side(a, b, c, d);
    away[k] = sum_of(normals[k], x) - Lanes{a[3], b[3], c[3], d[3]};
    const Mask is_there = zero + k < count;
    if (k > 0) is_out_of_order |= is_there & (away[k] < away[k - 1]);
    const Lanes nearer = bridging - (away[k] - away[0]);
    active[k] = is_there;
    if (k > 0) active[k] &= active[k - 1] & ~(nearer + f <= zero);
    if (last == k && any(active[k])) {
      s1 = active[k] ? s1 + nearer : s1;
      s2 = active[k] ? s2 + nearer * nearer : s2;
      const double number = k + 1;
      const Lanes under = s1 * s1 - number * (s2 - bridging * bridging);
      f = active[k] ? (-s1 + root(at_least(under, 0.0))) / number : f;
      last = k + 1;
    }
  }
  Lanes3 gradient = {};
  Lanes total = {};
  for (int k = 0; k < last; ++k) {
    const Lanes share = at_least(bridging - (away[k] - away[0]) + f, 0.0);
    gradient.x = active[k] ? gradient.x + share * normals[k].x : gradient.x;
    gradient.y = active[k] ? gradient.y + share * normals[k].y : gradient.y;
    gradient.z = active[k] ? gradient.z + share * normals[k].z : gradient.z;
    total = active[k] ? total + share : total;
  }
  gradient = {gradient.x / total, gradient.y / total, gradient.z / total};
  const Lanes level = away[0] + f;
  Lanes3 out;
  Lanes along;
  find_outward(gradient, normal, out, along);
  const Mask is_pulled = active[0] & (level > fat);
  find_pull(model, x, elastic, out, (fat - level) / along, is_pulled, weight, by);
  for (int l = 0; l < kLanes; ++l) unordered[l] = is_out_of_order[l] != 0;
}

// The same of nodes with one plane each, whose level is the distance from it. Sets their `outward`
// as well where the normals are `new_normals`.
[[gnu::always_inline]] inline void find_single_pulls(const SkinModel& model, const int* node,
                                                     bool new_normals, SkinState& state,
                                                     Lanes& weight, Lanes3& by) {
  const double bridging = model.settings.bridging;
  const Point a = plane_of(state.planes, node[0], 0), b = plane_of(state.planes, node[1], 0);
  const Point c = plane_of(state.planes, node[2], 0), d = plane_of(state.planes, node[3], 0);
  const Lanes3 x = gather(state.x.data(), node), plane = side_by_side(a, b, c, d);
  Lanes fat = {};
  for (int l = 0; l < kLanes; ++l) fat[l] = model.fat[node[l]];
  Lanes3 out;
  Lanes along = {};
  if (new_normals) {
    // As gradient_of() rounds it.
    const Lanes3 gradient = {bridging * plane.x / bridging, bridging * plane.y / bridging,
                             bridging * plane.z / bridging};
    const Lanes3 normal = gather(state.normals.data(), node);
    find_outward(gradient, normal, out, along);
    for (int l = 0; l < kLanes; ++l) {
      state.outward[node[l]] = Point{out.x[l], out.y[l], out.z[l], along[l]};
    }
  } else {
    out = gather(state.outward.data(), node);
    for (int l = 0; l < kLanes; ++l) along[l] = state.outward[node[l]][3];
  }
  const Lanes level = sum_of(plane, x) - Lanes{a[3], b[3], c[3], d[3]};
  const Lanes3 elastic = gather(state.elastic.data(), node);
  find_pull(model, x, elastic, out, (fat - level) / along, level > fat, weight, by);
}

// Sets `outward` of those of four nodes that have one plane, where others of them have not.
void find_outward_of_single(const SkinModel& model, const int* node, SkinState& state) {
  int single[kLanes], count = 0;
  for (int l = 0; l < kLanes; ++l) {
    if (state.planes.count[node[l]] == 1) single[count++] = node[l];
  }
  if (count == 0) return;
  for (int l = count; l < kLanes; ++l) single[l] = single[0];
  Lanes weight;
  Lanes3 by;
  find_single_pulls(model, single, true, state, weight, by);
}

// Sets pulls and inverse_weight of the nodes [first, last) of by_planes.
THEW_VECTORISED
void find_pulls(const SkinModel& model, int first, int last, bool new_normals, SkinState& state) {
  for (int n = first; n < last; n += kLanes) {
    int node[kLanes];
    for (int l = 0; l < kLanes; ++l) node[l] = state.by_planes[std::min(n + l, last - 1)];
    const int least = state.planes.count[node[0]], most = state.planes.count[node[kLanes - 1]];
    Lanes weight = {};
    Lanes3 by = {};
    bool unordered[kLanes] = {};
    if (least == 1 && most == 1) {
      find_single_pulls(model, node, new_normals, state, weight, by);
    } else if (most > 0) {
      if (new_normals) find_outward_of_single(model, node, state);
      find_four_pulls(model, state, node, most, weight, by, unordered);
    }
    scatter(by, node, state.pulls.data());
    for (int l = 0; l < kLanes; ++l) {
      if (unordered[l]) weight[l] = find_pull(model, node[l], state);
      weight[l] += model.weight[node[l]];
    }
    const Lanes inverse = 1.0 / weight;
    for (int l = 0; l < kLanes; ++l) state.inverse_weight[node[l]] = inverse[l];
  }
}

// The arrays of a sweep, so that none is looked up anew for each node.
struct Sweep {
  const int *first_neighbour, *neighbours, *planes_count;
  const double *weights, *inverse_weight, *fat;
  const Point *elastic, *turned, *pulls, *outward, *normals;
  const std::array<FleshPlanes::Plane, FleshPlanes::kMaxPlanes>* planes;
  Point *x, *displaced;
  double bridging, firm_fat, max_climb;
};

Sweep sweep_of(const SkinModel& model, SkinState& state) {
  const Lengths& lengths = model.settings.lengths;
  return {model.first_neighbour.data(),
          model.neighbours.data(),
          state.planes.count.data(),
          model.weights.data(),
          state.inverse_weight.data(),
          model.fat.data(),
          state.elastic.data(),
          state.turned.data(),
          state.pulls.data(),
          state.outward.data(),
          state.normals.data(),
          state.planes.planes.data(),
          state.x.data(),
          state.displaced.data(),
          model.settings.bridging,
          lengths.firm_fat,
          lengths.max_climb};
}

// Whether all edges of a node at x are surely long enough. It is exact where it is true.
[[gnu::always_inline]] inline bool are_long(const Sweep& of, int first, int last, Point x) {
  if (last - first < kLanes) return false;
  x[3] = 1.0;  // the limit is the fourth coordinate of `turned`
  Mask is_short = {};
  for (int next = first; next < last; next += kLanes) {
    const int k = std::min(next, last - kLanes);
    Point a = (x - of.x[of.neighbours[k]]) * of.turned[k];
    Point b = (x - of.x[of.neighbours[k + 1]]) * of.turned[k + 1];
    Point c = (x - of.x[of.neighbours[k + 2]]) * of.turned[k + 2];
    Point d = (x - of.x[of.neighbours[k + 3]]) * of.turned[k + 3];
    const Point xz0 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const Point xz1 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const Point yw0 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Point yw1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    const Lanes xs = __builtin_shufflevector(xz0, xz1, 0, 1, 4, 5);
    const Lanes zs = __builtin_shufflevector(xz0, xz1, 2, 3, 6, 7);
    const Lanes ys = __builtin_shufflevector(yw0, yw1, 0, 1, 4, 5);
    const Lanes limits = __builtin_shufflevector(yw0, yw1, 2, 3, 6, 7);
    is_short |= ~(xs + ys + zs > limits);  // in the order in which dot() sums
  }
  return !any(is_short);
}

// Moves a node at x out to the level `firm`, by max_climb at a time.
[[gnu::always_inline]] inline void climb(const Sweep& of, int i, double firm, Point& x) {
  const FleshPlanes::Plane* near = of.planes[i].data();
  for (int round = 0; round < 2; ++round) {
    FleshLevel level;
    find_level(near, of.planes_count[i], to_vec(x), of.bridging, level);
    if (level.active == 0 || level.level >= firm) break;
    const Vec3 gradient = gradient_of(near, level, of.bridging);
    const Vec3 out = outward_direction(gradient, of.normals[i]);
    x += to_point(std::min(climb_distance(gradient, out, firm - level.level), of.max_climb) * out);
  }
}

// The same over one plane.
[[gnu::always_inline]] inline void climb_single(const Sweep& of, int i, double firm, Point& x) {
  const FleshPlanes::Plane& plane = of.planes[i][0];
  for (int round = 0; round < 2; ++round) {
    const double level = plane.normal.dot(to_vec(x)) - plane.offset;
    if (level >= firm) break;
    Point out = of.outward[i];
    const double along = out[3];
    out[3] = 0.0;
    x += std::min((firm - level) / along, of.max_climb) * out;
  }
}

[[gnu::always_inline]] inline void relax_node(const Sweep& of, int i) {
  const int first = of.first_neighbour[i], last = of.first_neighbour[i + 1];
  Point sum{};  // sum of weighted displacements from the elastic shape
  for (int k = first; k < last; ++k) sum += of.weights[k] * of.displaced[of.neighbours[k]];
  sum += of.pulls[i];
  const Point elastic = of.elastic[i];
  Point x = of.x[i] + (elastic + sum * of.inverse_weight[i] - of.x[i]);
  if (!are_long(of, first, last, x)) {
    for (int k = first; k < last; ++k) {  // neighbours must not pass one another
      Point e = of.turned[k];
      e[3] = 0.0;
      const double lack = kMinEdge - dot(x - of.x[of.neighbours[k]], e) / dot(e, e);
      if (lack > 0.0) x += 0.5 * lack * e;
    }
  }
  const double firm = std::min(of.fat[i], of.firm_fat);
  if (of.planes_count[i] == 1) {
    climb_single(of, i, firm, x);
  } else {
    climb(of, i, firm, x);
  }
  of.x[i] = x;
  of.displaced[i] = x - elastic;
}

THEW_VECTORISED
void sweep_forwards(const Sweep& of, int nodes) {
  for (int i = 0; i < nodes; ++i) relax_node(of, i);
}

THEW_VECTORISED
void sweep_backwards(const Sweep& of, int nodes) {
  for (int i = nodes; i-- > 0;) relax_node(of, i);
}

}  // namespace

void relax(const SkinModel& model, const Loop& loop, bool new_normals, SkinState& state) {
  constexpr int kNodes = 512;  // that a thread takes at a time
  const int nodes = static_cast<int>(state.x.size());
  for (int i = 0; i < nodes; ++i) state.displaced[i] = state.x[i] - state.elastic[i];
  const auto pull = [&](bool newly) {
    loop.ranges(nodes, kNodes,
                [&](int first, int last) { find_pulls(model, first, last, newly, state); });
  };
  pull(new_normals);
  sweep_forwards(sweep_of(model, state), nodes);
  pull(false);
  sweep_backwards(sweep_of(model, state), nodes);
}

}  // namespace thew::skin
