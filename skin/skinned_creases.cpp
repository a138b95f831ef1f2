// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "rig/math.h"
#include "skin/skinned_skin.h"

namespace thew::skin {
namespace {

// Fold angle (rad) beyond that by the weights alone, from which on the smoothing of an edge begins
// and at which it is complete. The range keeps it from setting in abruptly. Chosen by trial.
constexpr double kBegins = 25.0 * kDegree, kWhole = 40.0 * kDegree;

double fold_of(const Surface& surface, const Points& x, const std::array<int, 2>& triangles) {
  const Vec3 a = face_normal(surface, x, triangles[0]), b = face_normal(surface, x, triangles[1]);
  return arc_tan2(a.cross(b).norm(), a.dot(b));
}

// Sets the sharpness (0..1) of each vertex: that of the sharpest edge of its triangles, and half of
// that for its neighbours.
void find_sharp(const SkinnedSkin& skin, const Points& x, SkinnedWork& work) {
  work.own_sharp.assign(x.size(), 0.0);
  for (size_t e = 0; e < skin.edges.size(); ++e) {
    const double share =
        smoothstep(kBegins, kWhole, fold_of(skin.surface, x, skin.edges[e]) - work.folds[e]);
    if (share <= 0.0) continue;
    for (const int t : skin.edges[e]) {
      for (const int v : skin.surface.triangles[t]) {
        work.own_sharp[v] = std::max(work.own_sharp[v], share);
      }
    }
  }
  work.sharp = work.own_sharp;
  for (size_t i = 0; i < x.size(); ++i) {
    for (int k = skin.first_neighbour[i]; k < skin.first_neighbour[i + 1]; ++k) {
      work.sharp[i] = std::max(work.sharp[i], 0.5 * work.own_sharp[skin.neighbours[k]]);
    }
  }
}

}  // namespace

void even_creases(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  work.folds.clear();
  for (const auto& edge : skin.edges) {
    work.folds.push_back(fold_of(skin.surface, work.carried, edge));
  }
  work.displacement.resize(x.size());
  for (size_t i = 0; i < x.size(); ++i) work.displacement[i] = x[i] - work.carried[i];
  for (int pass = 0; pass < skin.crease_passes; ++pass) {
    find_sharp(skin, x, work);
    work.before = work.displacement;
    for (size_t i = 0; i < x.size(); ++i) {
      const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      if (work.sharp[i] <= 0.0 || begin == end) continue;
      Point sum{};
      for (int k = begin; k < end; ++k) sum += work.before[skin.neighbours[k]];
      const double share = 0.5 * work.sharp[i];
      work.displacement[i] = (1.0 - share) * work.before[i] + (share / (end - begin)) * sum;
      x[i] = work.carried[i] + work.displacement[i];
    }
  }
}

}  // namespace thew::skin
