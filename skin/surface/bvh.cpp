// SPDX-License-Identifier: Apache-2.0
//
// Binned surface-area-heuristic build (Wald 2007), bottom-up refit, nearest point with a shrinking
// bound, sign by angle-weighted pseudonormals (Baerentzen and Aanaes 2005).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "rig/vectorise.h"
#include "skin/surface/surface.h"

namespace thew::skin {
namespace {

constexpr int kBins = 16;
constexpr int kLeaf = 4;     // triangles
constexpr int kStack = 192;  // entries; each split leaves at least an eighth on either side, so 150
                             // levels suffice for 2^31 triangles

double half_area(const NodeBox& box) {
  const Point d = box.high - box.low;
  return d[0] >= 0.0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0.0;
}

[[gnu::always_inline]] inline void add_triangle(const Triangle& triangle, const Points& x,
                                                NodeBox& box) {
  for (const int corner : triangle) grow(box, x[corner], x[corner]);
}

// Splits order[first, first + count) in two by the cheapest plane between the bins of the
// centroids.
int split(const std::vector<NodeBox>& boxes, std::vector<int>& order, int first, int count) {
  NodeBox centroids = empty_box();
  for (int i = first; i < first + count; ++i) {
    const NodeBox& box = boxes[order[i]];
    const Point centre = 0.5 * (box.low + box.high);
    grow(centroids, centre, centre);
  }
  const Point extent = centroids.high - centroids.low;
  const int axis = longest_axis(extent);
  const int middle = first + count / 2;
  const auto centre = [&](int t) { return 0.5 * (boxes[t].low[axis] + boxes[t].high[axis]); };
  const auto halve = [&] {
    std::nth_element(
        order.begin() + first, order.begin() + middle, order.begin() + first + count,
        [&](int s, int t) { return centre(s) != centre(t) ? centre(s) < centre(t) : s < t; });
    return middle;
  };
  if (!(extent[axis] > 0.0)) return halve();
  const auto bin_of = [&](int t) {
    return std::min(kBins - 1,
                    static_cast<int>(kBins * (centre(t) - centroids.low[axis]) / extent[axis]));
  };
  std::array<NodeBox, kBins> bins;
  bins.fill(empty_box());
  int counts[kBins] = {};
  for (int i = first; i < first + count; ++i) {
    const NodeBox& box = boxes[order[i]];
    grow(bins[bin_of(order[i])], box.low, box.high);
    ++counts[bin_of(order[i])];
  }
  double right_cost[kBins] = {};
  NodeBox right = empty_box();
  for (int b = kBins - 1, n = 0; b > 0; --b) {
    grow(right, bins[b].low, bins[b].high);
    n += counts[b];
    right_cost[b] = half_area(right) * n;
  }
  NodeBox left = empty_box();
  int best = 0, left_count = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  for (int b = 0, n = 0; b + 1 < kBins; ++b) {
    grow(left, bins[b].low, bins[b].high);
    n += counts[b];
    const double cost = half_area(left) * n + right_cost[b + 1];
    if (n > 0 && n < count && cost < best_cost) best = b, best_cost = cost, left_count = n;
  }
  // A very uneven split would make the tree too deep on stretched data.
  if (left_count < count / 8 || count - left_count < count / 8) return halve();
  std::stable_partition(order.begin() + first, order.begin() + first + count,
                        [&](int t) { return bin_of(t) <= best; });
  return first + left_count;
}

using Float4 = float __attribute__((vector_size(16)));

// Two float steps cover the rounding of the conversion.
[[gnu::always_inline]] inline void round_both(const Point& v, Float4& below, Float4& above) {
  const Float4 f = __builtin_convertvector(v, Float4), by = (f < 0.0f ? -f : f) * 1.2e-7f;
  below = f - by - std::numeric_limits<float>::min();
  above = f + by + std::numeric_limits<float>::min();
}

// A point rounded up and down, in the layout in which lo and hi of a box are read: (lo, hi[0]) and
// (lo[2], hi).
struct BoxQuery {
  Float4 up, down;
  explicit BoxQuery(const Vec3& p) {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    Float4 below;
    round_both(to_point(p), below, up);
    up[3] = kFar;
    down = Float4{-kFar, below[0], below[1], below[2]};
  }
};

// A lower bound of the squared distance to the box: the last factor covers the rounding here.
float box_distance2(const Bvh::Node& node, const BoxQuery& p) {
  Float4 low, high;
  std::memcpy(&low, node.lo, sizeof low);
  std::memcpy(&high, node.lo + 2, sizeof high);
  const Float4 zero{};
  Float4 a = low - p.up, b = p.down - high;
  a = a > zero ? a : zero;
  b = b > zero ? b : zero;
  a = a * a + b * b;
  return ((a[0] + a[1]) + (a[2] + a[3])) * (1.0f - 2e-6f);
}

struct OnTriangle {
  double b[3];
  double distance2;
};

// Ericson, Real-Time Collision Detection, 5.1.5. On corners and edges the other barycentric
// coordinates are exactly 0.
OnTriangle nearest_on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const auto at = [&](double v, double w) {
    return OnTriangle{{1.0 - v - w, v, w}, (ap - v * ab - w * ac).squaredNorm()};
  };
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {{1, 0, 0}, ap.squaredNorm()};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {{0, 1, 0}, bp.squaredNorm()};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return at(d1 / (d1 - d3), 0.0);
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {{0, 0, 1}, cp.squaredNorm()};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return at(0.0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    const OnTriangle edge = at(1.0 - w, w);
    return {{0.0, edge.b[1], edge.b[2]}, edge.distance2};
  }
  const double sum = va + vb + vc;
  if (!(sum > 0.0))
    return {{1, 0, 0},
            ap.squaredNorm()};  // the triangle has no area, and rounding missed its edges
  return at(vb / sum, vc / sum);
}

// Outward unit normal at a point of a triangle: that of the face, edge or corner on which it lies,
// which its barycentric coordinates of 0 tell.
Vec3 pseudonormal(const Surface& surface, const Points& x, int triangle, const double* b) {
  for (int k = 0; k < 3; ++k) {
    const bool first = b[k] > 0.0, second = b[(k + 1) % 3] > 0.0, third = b[(k + 2) % 3] > 0.0;
    if (first && !second && !third) return node_normal(surface, x, surface.triangles[triangle][k]);
    if (first && second && !third) {
      Vec3 n = face_normal(surface, x, triangle);
      const int across = surface.neighbours[triangle][k];
      if (across >= 0) n += face_normal(surface, x, across);
      const double length = n.norm();
      return length > 0.0 ? Vec3(n / length)
                          : node_normal(surface, x, surface.triangles[triangle][k]);
    }
  }
  return face_normal(surface, x, triangle);
}

// Whether p lies outside a convex surface over the inside of a face: no other face is as near then.
// Not next to an edge, where by rounding the face across it may be as near, because the result must
// not depend on the order of the search.
bool is_over_face(const Surface& surface, const Points& x, const ClosestPoint& near,
                  const Vec3& p) {
  constexpr double kBeside = 1e-6;  // of the distance to p; its square is far above rounding
  const Triangle& t = surface.triangles[near.triangle];
  const Vec3 corner[3] = {to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]])};
  const Vec3 across = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const double distance = (p - corner[0]).norm() + (corner[1] - corner[0]).norm();
  for (int k = 0; k < 3; ++k) {
    const double edge = (corner[(k + 2) % 3] - corner[(k + 1) % 3]).norm();
    if (!(near.barycentric[k] * across.norm() > kBeside * distance * edge)) return false;
  }
  return across.dot(p - corner[0]) > 0.0;
}

THEW_VECTORISED
void grow_over(const Points& x, NodeBox& box) {
  for (const Point& p : x) grow(box, p, p);
}

}  // namespace

// The box is grown in a variable of its own, because the compiler may align the returned one to
// only half of what a vector needs.
NodeBox box_of(const Points& x) {
  NodeBox grown = empty_box();
  grow_over(x, grown);
  const NodeBox box = grown;
  return box;
}

int longest_axis(const Point& extent) {
  if (extent[0] >= extent[1] && extent[0] >= extent[2]) return 0;
  return extent[1] >= extent[2] ? 1 : 2;
}

bool are_near(const NodeBox& a, const NodeBox& b, double reach) {
  for (int k = 0; k < 3; ++k) {
    if (a.low[k] > b.high[k] + reach || b.low[k] > a.high[k] + reach) return false;
  }
  return true;
}

Bvh build_bvh(const Surface& surface, const Points& x) {
  Bvh bvh;
  const int count = static_cast<int>(surface.triangles.size());
  std::vector<NodeBox> boxes(count, empty_box());
  for (int t = 0; t < count; ++t) {
    bvh.order.push_back(t);
    add_triangle(surface.triangles[t], x, boxes[t]);
  }
  bvh.nodes.push_back({{}, {}, 0, count});
  for (size_t n = 0; n < bvh.nodes.size();
       ++n) {  // breadth first, so children come after their parents
    const int first = bvh.nodes[n].first, size = bvh.nodes[n].count;
    if (size <= kLeaf) continue;
    const int middle = split(boxes, bvh.order, first, size);
    bvh.nodes[n].first = static_cast<int>(bvh.nodes.size());
    bvh.nodes[n].count = 0;
    bvh.nodes.push_back({{}, {}, first, middle - first});
    bvh.nodes.push_back({{}, {}, middle, first + size - middle});
  }
  refit_bvh(surface, x, bvh);
  return bvh;
}

THEW_VECTORISED
void refit_bvh(const Surface& surface, const Points& x, Bvh& bvh) {
  for (size_t n = bvh.nodes.size(); n-- > 0;) {
    Bvh::Node& node = bvh.nodes[n];
    if (node.count > 0 || bvh.order.empty()) {
      NodeBox box = empty_box();
      for (int i = node.first; i < node.first + node.count; ++i) {
        add_triangle(surface.triangles[bvh.order[i]], x, box);
      }
      Float4 lo, hi, unused;
      round_both(box.low, lo, unused);
      round_both(box.high, unused, hi);
      for (int k = 0; k < 3; ++k) {
        node.lo[k] = lo[k];
        node.hi[k] = hi[k];
      }
      continue;
    }
    const Bvh::Node &one = bvh.nodes[node.first], &two = bvh.nodes[node.first + 1];
    for (int k = 0; k < 3; ++k) {
      node.lo[k] = std::min(one.lo[k], two.lo[k]);
      node.hi[k] = std::max(one.hi[k], two.hi[k]);
    }
  }
}

double box_distance(const Bvh& bvh, const Point& p) {
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double off = std::max({bvh.nodes[0].lo[k] - p[k], p[k] - bvh.nodes[0].hi[k], 0.0});
    squared += off * off;
  }
  return std::sqrt(squared);
}

ClosestPoint closest_point(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                           double bound, int hint) {
  ClosestPoint best;
  double best2 = bound * bound;
  const auto test = [&](int t) {
    const Triangle& corner = surface.triangles[t];
    const OnTriangle near =
        nearest_on_triangle(to_vec(x[corner[0]]), to_vec(x[corner[1]]), to_vec(x[corner[2]]), p);
    // Of equally near triangles the one of the lowest index wins, so that the order of the search
    // does not matter.
    if (near.distance2 > best2 ||
        (near.distance2 == best2 && best.triangle >= 0 && best.triangle <= t)) {
      return;
    }
    best2 = near.distance2;
    best.triangle = t;
    std::copy(near.b, near.b + 3, best.barycentric);
  };
  if (hint >= 0 && hint < static_cast<int>(surface.triangles.size())) test(hint);
  const bool found = surface.convex && best.triangle >= 0 && is_over_face(surface, x, best, p);
  struct Entry {
    int node;
    float distance2;
  } stack[kStack];
  const BoxQuery query(p);
  int top = 0;
  if (!bvh.order.empty() && !found) stack[top++] = {0, box_distance2(bvh.nodes[0], query)};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.distance2 > best2) continue;
    const Bvh::Node& node = bvh.nodes[entry.node];
    for (int i = node.first; i < node.first + node.count; ++i) {
      if (bvh.order[i] != hint) test(bvh.order[i]);
    }
    if (node.count > 0) continue;
    Entry near{node.first, box_distance2(bvh.nodes[node.first], query)};
    Entry far{node.first + 1, box_distance2(bvh.nodes[node.first + 1], query)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (far.distance2 <= best2) stack[top++] = far;
    if (near.distance2 <= best2) stack[top++] = near;
  }
  if (best.triangle < 0) return best;
  const Triangle& t = surface.triangles[best.triangle];
  const double* b = best.barycentric;
  best.point = b[0] * to_vec(x[t[0]]) + b[1] * to_vec(x[t[1]]) + b[2] * to_vec(x[t[2]]);
  best.normal = pseudonormal(surface, x, best.triangle, b);
  best.distance = std::sqrt(best2);
  if (best.normal.dot(p - best.point) < 0.0) best.distance = -best.distance;
  return best;
}

void triangles_near(const Bvh& bvh, const Vec3& p, double reach, std::vector<int>& triangles) {
  triangles.clear();
  if (bvh.order.empty()) return;
  const BoxQuery query(p);
  int stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Node& node = bvh.nodes[stack[--top]];
    if (box_distance2(node, query) > reach * reach) continue;
    triangles.insert(triangles.end(), bvh.order.begin() + node.first,
                     bvh.order.begin() + node.first + node.count);
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
}

ClosestPoint closest_on_triangle(const Surface& surface, const Points& x, int triangle,
                                 const Vec3& p) {
  const Triangle& t = surface.triangles[triangle];
  const Vec3 a = to_vec(x[t[0]]), b = to_vec(x[t[1]]), c = to_vec(x[t[2]]);
  const OnTriangle near = nearest_on_triangle(a, b, c, p);
  ClosestPoint point;
  point.triangle = triangle;
  std::copy(near.b, near.b + 3, point.barycentric);
  point.point = near.b[0] * a + near.b[1] * b + near.b[2] * c;
  point.normal = face_normal(surface, x, triangle);
  point.distance = std::sqrt(near.distance2);
  if (point.normal.dot(p - point.point) < 0.0) point.distance = -point.distance;
  return point;
}

}  // namespace thew::skin
