// SPDX-License-Identifier: Apache-2.0
//
// Binned surface-area-heuristic build (Wald 2007) and bottom-up refit.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rig/vectorise.h"
#include "skin/surface/box_query.h"
#include "skin/surface/surface.h"

namespace thew::skin {
namespace {

constexpr int kBins = 16;
constexpr int kLeaf = 4;  // triangles

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

// The children of a node of the tree and theirs, by the largest boxes first, up to eight.
std::vector<int> descendants(const Bvh& bvh, int root) {
  const auto area = [&](int n) {
    const Bvh::Node& node = bvh.nodes[n];
    double side[3];
    for (int k = 0; k < 3; ++k) side[k] = node.hi[k] - node.lo[k];
    return node.count > 0 ? -1.0 : side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
  };
  std::vector<int> all = {root};
  while (all.size() < Bvh::Wide::kChildren) {
    const auto largest =
        std::max_element(all.begin(), all.end(), [&](int a, int b) { return area(a) < area(b); });
    const Bvh::Node& node = bvh.nodes[*largest];
    if (node.count > 0) break;
    *largest = node.first;
    all.push_back(node.first + 1);
  }
  return all;
}

void widen(Bvh& bvh) {
  if (bvh.order.empty()) return;
  std::vector<int> roots = {0};  // of each wide node
  for (size_t w = 0; w < roots.size(); ++w) {
    Bvh::Wide wide;
    std::fill(wide.node, wide.node + Bvh::Wide::kChildren, -1);
    std::fill(wide.child, wide.child + Bvh::Wide::kChildren, -1);
    int k = 0;
    for (const int node : descendants(bvh, roots[w])) {
      wide.node[k] = node;
      if (bvh.nodes[node].count == 0) {
        wide.child[k] = static_cast<int>(roots.size());
        roots.push_back(node);
      }
      ++k;
    }
    bvh.wide.push_back(wide);
  }
}

void refit_wide(Bvh& bvh) {
  constexpr float kNowhere = std::numeric_limits<float>::infinity();
  for (Bvh::Wide& wide : bvh.wide) {
    for (int k = 0; k < Bvh::Wide::kChildren; ++k) {
      const int node = wide.node[k];
      for (int axis = 0; axis < 3; ++axis) {
        wide.low[axis][k] = node < 0 ? kNowhere : bvh.nodes[node].lo[axis];
        wide.high[axis][k] = node < 0 ? -kNowhere : bvh.nodes[node].hi[axis];
      }
    }
  }
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
  widen(bvh);
  refit_wide(bvh);
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
  refit_wide(bvh);
}

double box_distance(const Bvh& bvh, const Point& p) { return box_distance(bvh, {p, p}); }

double box_distance(const Bvh& bvh, const NodeBox& box) {
  double squared = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double off =
        std::max({bvh.nodes[0].lo[k] - box.high[k], box.low[k] - bvh.nodes[0].hi[k], 0.0});
    squared += off * off;
  }
  return std::sqrt(squared);
}

}  // namespace thew::skin
