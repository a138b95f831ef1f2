// SPDX-License-Identifier: Apache-2.0
//
// Binned surface-area-heuristic build (Wald 2007) and bottom-up refit.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "rig/vectorise.h"
#include "skin/surface/box_query.h"
#include "skin/surface/surface.h"

namespace thew::skin {
namespace {

constexpr int kBins = 16;
constexpr int kLeaf = Bvh::Block::kHalf;  // triangles
constexpr float kNowhere = std::numeric_limits<float>::infinity();

double half_area(const NodeBox& box) {
  const Point d = box.high - box.low;
  return d[0] >= 0.0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0.0;
}

[[gnu::always_inline]] inline void add_triangle(const Triangle& triangle, const Points& x,
                                                NodeBox& box) {
  for (const int corner : triangle) grow(box, x[corner], x[corner]);
}

// Of each triangle while a tree is built.
struct Building {
  std::vector<NodeBox> boxes;
  Points centres;
  std::vector<unsigned char> bin;  // in the node that is split
  std::vector<int> later;          // scratch: those beyond the plane
};

THEW_VECTORISED
void find_boxes(const Surface& surface, const Points& x, Building& building) {
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    NodeBox box = empty_box();
    add_triangle(surface.triangles[t], x, box);
    building.boxes[t] = box;
    building.centres[t] = 0.5 * (box.low + box.high);
  }
}

// Splits order[first, first + count) in two by the cheapest plane between the bins of the
// centroids.
THEW_VECTORISED
int split(Building& building, std::vector<int>& order, int first, int count) {
  const Points& centres = building.centres;
  NodeBox centroids = empty_box();
  for (int i = first; i < first + count; ++i) {
    grow(centroids, centres[order[i]], centres[order[i]]);
  }
  const Point extent = centroids.high - centroids.low;
  const int axis = longest_axis(extent);
  const int middle = first + count / 2;
  const auto halve = [&] {
    std::nth_element(
        order.begin() + first, order.begin() + middle, order.begin() + first + count,
        [&](int s, int t) {
          return centres[s][axis] != centres[t][axis] ? centres[s][axis] < centres[t][axis] : s < t;
        });
    return middle;
  };
  if (!(extent[axis] > 0.0)) return halve();
  std::array<NodeBox, kBins> bins;
  bins.fill(empty_box());
  int counts[kBins] = {};
  for (int i = first; i < first + count; ++i) {
    const int t = order[i];
    const double along = kBins * (centres[t][axis] - centroids.low[axis]) / extent[axis];
    const int bin = std::min(kBins - 1, static_cast<int>(along));
    building.bin[t] = static_cast<unsigned char>(bin);
    grow(bins[bin], building.boxes[t].low, building.boxes[t].high);
    ++counts[bin];
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
  building.later.clear();
  int kept = first;
  for (int i = first; i < first + count; ++i) {
    const int t = order[i];
    if (building.bin[t] <= best) {
      order[kept++] = t;
    } else {
      building.later.push_back(t);
    }
  }
  std::copy(building.later.begin(), building.later.end(), order.begin() + kept);
  return kept;
}

void divide_in_blocks(const Surface& surface, Bvh& bvh) {
  if (bvh.order.empty()) return;
  bvh.block_of.assign(bvh.nodes.size(), -1);
  const auto add_leaf = [&](int n, int half) {
    Bvh::Block& block = bvh.blocks.back();
    const Bvh::Node& leaf = bvh.nodes[n];
    bvh.block_of[n] = static_cast<int>(bvh.blocks.size()) - 1;
    for (int i = 0; i < leaf.count; ++i) {
      const int lane = half * Bvh::Block::kHalf + i, t = bvh.order[leaf.first + i];
      block.triangle[lane] = t;
      for (int k = 0; k < 3; ++k) block.node[k][lane] = surface.triangles[t][k];
    }
  };
  for (size_t n = 0; n < bvh.nodes.size(); ++n) {
    const Bvh::Node& node = bvh.nodes[n];
    const bool is_leaf = node.count > 0;
    if (bvh.block_of[n] >= 0) continue;
    if (!is_leaf && (bvh.nodes[node.first].count == 0 || bvh.nodes[node.first + 1].count == 0)) {
      continue;
    }
    Bvh::Block& block = bvh.blocks.emplace_back();
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < Bvh::Block::kLanes; ++l) {
        block.low[k][l] = kNowhere;
        block.high[k][l] = -kNowhere;
      }
    }
    const int leaf = is_leaf ? static_cast<int>(n) : node.first;
    bvh.block_of[n] = static_cast<int>(bvh.blocks.size()) - 1;
    add_leaf(leaf, 0);
    if (!is_leaf) add_leaf(leaf + 1, 1);
  }
}

// The children of a node of the tree and theirs, by the largest boxes first, up to eight.
std::vector<int> descendants(const Bvh& bvh, int root) {
  const auto area = [&](int n) {
    const Bvh::Node& node = bvh.nodes[n];
    double side[3];
    for (int k = 0; k < 3; ++k) side[k] = node.hi[k] - node.lo[k];
    return bvh.block_of[n] >= 0 ? -1.0 : side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
  };
  std::vector<int> all = {root};
  while (all.size() < Bvh::Wide::kChildren) {
    const auto largest =
        std::max_element(all.begin(), all.end(), [&](int a, int b) { return area(a) < area(b); });
    const Bvh::Node& node = bvh.nodes[*largest];
    if (bvh.block_of[*largest] >= 0) break;
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
      if (bvh.block_of[node] < 0) {
        wide.child[k] = static_cast<int>(roots.size());
        roots.push_back(node);
      }
      ++k;
    }
    bvh.wide.push_back(wide);
  }
}

void refit_wide(Bvh& bvh) {
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
  Building building;
  building.boxes.resize(count);
  building.centres.resize(count);
  building.bin.resize(count);
  find_boxes(surface, x, building);
  bvh.order.resize(count);
  std::iota(bvh.order.begin(), bvh.order.end(), 0);
  bvh.nodes.push_back({{}, {}, 0, count});
  for (size_t n = 0; n < bvh.nodes.size();
       ++n) {  // breadth first, so children come after their parents
    const int first = bvh.nodes[n].first, size = bvh.nodes[n].count;
    if (size <= kLeaf) continue;
    const int middle = split(building, bvh.order, first, size);
    bvh.nodes[n].first = static_cast<int>(bvh.nodes.size());
    bvh.nodes[n].count = 0;
    bvh.nodes.push_back({{}, {}, first, middle - first});
    bvh.nodes.push_back({{}, {}, middle, first + size - middle});
  }
  divide_in_blocks(surface, bvh);
  refit_bvh(surface, x, bvh);
  widen(bvh);
  refit_wide(bvh);
  return bvh;
}

namespace {

// Sets the boxes of the triangles of a leaf in its block, and its own.
[[gnu::always_inline]] inline void refit_leaf(const Surface& surface, const Points& x, Bvh& bvh,
                                              Bvh::Node& leaf, Bvh::Block& block) {
  Float4 low[kLeaf], high[kLeaf];
  for (int i = 0; i < kLeaf; ++i) {
    low[i] = Float4{} + kNowhere;
    high[i] = Float4{} - kNowhere;
  }
  for (int i = 0; i < leaf.count; ++i) {
    const Triangle& triangle = surface.triangles[bvh.order[leaf.first + i]];
    const Point &a = x[triangle[0]], &b = x[triangle[1]], &c = x[triangle[2]];
    const Point ab_low = a < b ? a : b, ab_high = a > b ? a : b;
    Float4 unused;
    round_both(ab_low < c ? ab_low : c, low[i], unused);
    round_both(ab_high > c ? ab_high : c, unused, high[i]);
  }
  const int lane = bvh.order[leaf.first] == block.triangle[0] ? 0 : kLeaf;
  const auto place = [&](const Float4* rows, float(*lanes)[Bvh::Block::kLanes])
      __attribute__((always_inline)) {
    const Float4 xy0 = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
    const Float4 xy1 = __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5);
    const Float4 z0 = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
    const Float4 z1 = __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7);
    const Float4 axes[3] = {__builtin_shufflevector(xy0, xy1, 0, 1, 4, 5),
                            __builtin_shufflevector(xy0, xy1, 2, 3, 6, 7),
                            __builtin_shufflevector(z0, z1, 0, 1, 4, 5)};
    for (int k = 0; k < 3; ++k) std::memcpy(&lanes[k][lane], &axes[k], sizeof axes[k]);
  };
  place(low, block.low);
  place(high, block.high);
  for (int i = 1; i < kLeaf; ++i) {
    low[0] = low[i] < low[0] ? low[i] : low[0];
    high[0] = high[i] > high[0] ? high[i] : high[0];
  }
  for (int k = 0; k < 3; ++k) {
    leaf.lo[k] = low[0][k];
    leaf.hi[k] = high[0][k];
  }
}

}  // namespace

THEW_VECTORISED
void refit_bvh(const Surface& surface, const Points& x, Bvh& bvh) {
  for (size_t n = bvh.nodes.size(); n-- > 0;) {
    Bvh::Node& node = bvh.nodes[n];
    if (node.count > 0) {
      refit_leaf(surface, x, bvh, node, bvh.blocks[bvh.block_of[n]]);
      continue;
    }
    if (bvh.order.empty()) {  // a box that contains nothing
      for (int k = 0; k < 3; ++k) {
        node.lo[k] = kNowhere;
        node.hi[k] = -kNowhere;
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
