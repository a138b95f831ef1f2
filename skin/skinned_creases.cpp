// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "rig/math.h"
#include "skin/skinned_skin.h"

namespace thew {
namespace {

// Beyond what the weights alone fold: from here on an edge is evened out, from there on wholly, so
// that none begins at once.
constexpr double kLeast = 25.0 * kDegree, kMost = 40.0 * kDegree;

struct Edge {
  std::array<int, 2> triangles;
  double carried;  // rad, by which they are folded as the weights have them
};

double fold_of(const Surface& surface, const Rows& x, const std::array<int, 2>& triangles) {
  const Vec3 a = face_normal(surface, x, triangles[0]), b = face_normal(surface, x, triangles[1]);
  return arc_tan2(a.cross(b).norm(), a.dot(b));
}

std::vector<Edge> edges_near(const SkinnedSkin& skin, const Rows& carried) {
  const Surface& surface = skin.surface;
  std::vector<Edge> edges;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Triangle& c = surface.triangles[t];
    if (!skin.near[c[0]] && !skin.near[c[1]] && !skin.near[c[2]]) continue;
    for (const int u : surface.neighbours[t]) {
      if (u < 0) continue;
      const Triangle& d = surface.triangles[u];
      if (u < t && (skin.near[d[0]] || skin.near[d[1]] || skin.near[d[2]])) continue;  // there
      edges.push_back({{t, u}, fold_of(surface, carried, {t, u})});
    }
  }
  return edges;
}

// 0..1 by vertex, of the sharpest edge of its triangles, and half of that to the neighbours.
void find_sharp(const SkinnedSkin& skin, const std::vector<Edge>& edges, const Rows& x,
                std::vector<double>& sharp, std::vector<double>& own) {
  std::fill(own.begin(), own.end(), 0.0);
  for (const Edge& edge : edges) {
    const double share =
        smoothstep(kLeast, kMost, fold_of(skin.surface, x, edge.triangles) - edge.carried);
    if (share <= 0.0) continue;
    for (const int t : edge.triangles) {
      for (const int v : skin.surface.triangles[t]) own[v] = std::max(own[v], share);
    }
  }
  sharp = own;
  for (size_t i = 0; i < own.size(); ++i) {
    for (int k = skin.first_neighbour[i]; k < skin.first_neighbour[i + 1]; ++k) {
      sharp[i] = std::max(sharp[i], 0.5 * own[skin.neighbours[k]]);
    }
  }
}

}  // namespace

void even_creases(const SkinnedSkin& skin, const Rows& carried, Rows& x) {
  const std::vector<Edge> edges = edges_near(skin, carried);
  std::vector<double> sharp(x.size()), own(x.size());
  Rows by(x.size()), before;
  for (size_t i = 0; i < x.size(); ++i) by[i] = x[i] - carried[i];
  for (int pass = 0; pass < skin.crease_passes; ++pass) {
    find_sharp(skin, edges, x, sharp, own);
    before = by;
    for (size_t i = 0; i < x.size(); ++i) {
      const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      if (sharp[i] <= 0.0 || begin == end) continue;
      Row sum{};
      for (int k = begin; k < end; ++k) sum += before[skin.neighbours[k]];
      const double share = 0.5 * sharp[i];
      by[i] = (1.0 - share) * before[i] + (share / (end - begin)) * sum;
      x[i] = carried[i] + by[i];
    }
  }
}

}  // namespace thew
