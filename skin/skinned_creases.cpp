// SPDX-License-Identifier: Apache-2.0
//
// A pass moves only the vertices at creases, so that from the second pass on only their triangles
// are looked at again: creases are few, however fine the mesh is.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "rig/math.h"
#include "skin/skinned_skin.h"

namespace thew::skin {
namespace {

// Fold angle (rad) beyond that by the weights alone, from which on the smoothing of an edge begins
// and at which it is complete. The range keeps it from setting in abruptly. Chosen by trial.
constexpr double kBegins = 25.0 * kDegree, kWhole = 40.0 * kDegree;

using Fold = SkinnedWork::Fold;

Fold fold_between(const Vec3& a, const Vec3& b) { return {a.dot(b), a.cross(b).norm()}; }
double angle_of(const Fold& fold) { return arc_tan2(fold.sine, fold.cosine); }

// How sharply an edge is folded beyond what the weights fold it by, 0..1.
double share_of(const Fold& now, const Fold& carried) {
  static const double kSmooth = sin_cos(kBegins).cos + 1e-9;  // more than rounding
  if (now.cosine * carried.cosine + now.sine * carried.sine > kSmooth) return 0.0;
  return smoothstep(kBegins, kWhole, angle_of(now) - angle_of(carried));
}

// Sets the share of an edge, of which the triangles have their normals, and lists it if it is
// sharp.
void look_at(const SkinnedSkin& skin, int edge, SkinnedWork& work) {
  const auto& [s, t] = skin.edges[edge];
  work.shares[edge] = share_of(fold_between(work.normals[s], work.normals[t]), work.folds[edge]);
  if (work.shares[edge] > 0.0) work.sharp_edges.push_back(edge);
}

// Sets `sharp` (0..1) of the vertices that have some, and lists them: the share of the sharpest
// edge of its triangles, and half of that for its neighbours.
void find_sharp(const SkinnedSkin& skin, SkinnedWork& work) {
  for (const int v : work.sharp_vertices) work.own_sharp[v] = work.sharp[v] = 0.0;
  work.sharp_vertices.clear();
  const auto raise = [&](int v, double& sharp, double to) {
    if (work.own_sharp[v] <= 0.0 && work.sharp[v] <= 0.0) work.sharp_vertices.push_back(v);
    sharp = std::max(sharp, to);
  };
  for (const int edge : work.sharp_edges) {
    for (const int t : skin.edges[edge]) {
      for (const int v : skin.surface.triangles[t]) {
        raise(v, work.own_sharp[v], work.shares[edge]);
      }
    }
  }
  const size_t own = work.sharp_vertices.size();
  for (size_t k = 0; k < own; ++k) {
    const int v = work.sharp_vertices[k];
    work.sharp[v] = std::max(work.sharp[v], work.own_sharp[v]);
    for (int n = skin.first_neighbour[v]; n < skin.first_neighbour[v + 1]; ++n) {
      const int other = skin.neighbours[n];
      raise(other, work.sharp[other], 0.5 * work.own_sharp[v]);
    }
  }
}

// Looks at all edges.
void begin(const SkinnedSkin& skin, const Points& x, SkinnedWork& work) {
  const auto find_normals = [&](const Points& of) {
    for (const auto& edge : skin.edges) {
      for (const int t : edge) work.seen[t] = 1;
    }
    for (size_t t = 0; t < work.seen.size(); ++t) {
      if (work.seen[t]) work.normals[t] = face_normal(skin.surface, of, static_cast<int>(t));
    }
  };
  const int edges = static_cast<int>(skin.edges.size());
  work.seen.assign(skin.surface.triangles.size(), 0);
  work.normals.resize(work.seen.size());
  work.folds.resize(edges);
  find_normals(work.carried);
  for (int e = 0; e < edges; ++e) {
    const auto& [s, t] = skin.edges[e];
    work.folds[e] = fold_between(work.normals[s], work.normals[t]);
  }
  find_normals(x);
  work.shares.resize(edges);
  work.sharp_edges.clear();
  for (int e = 0; e < edges; ++e) look_at(skin, e, work);
  work.sharp_vertices.clear();
  work.sharp.assign(x.size(), 0.0);
  work.own_sharp.assign(x.size(), 0.0);
  work.displacement.resize(x.size());
  for (size_t i = 0; i < x.size(); ++i) work.displacement[i] = x[i] - work.carried[i];
  work.before.resize(x.size());
  work.seen.assign(skin.surface.triangles.size(), 0);
  work.seen_edges.assign(edges, 0);
}

// Looks again at the edges of triangles of which a vertex has moved.
void look_again(const SkinnedSkin& skin, const Points& x, SkinnedWork& work) {
  work.moved_triangles.clear();
  for (const int v : work.sharp_vertices) {
    for (const int t : skin.surface.vertex_triangles[v]) {
      if (work.seen[t]) continue;
      work.seen[t] = 1;
      work.moved_triangles.push_back(t);
      work.normals[t] = face_normal(skin.surface, x, t);
    }
  }
  std::erase_if(work.sharp_edges, [&](int edge) {
    const auto& [s, t] = skin.edges[edge];
    return work.seen[s] || work.seen[t];
  });
  work.moved_edges.clear();
  for (const int t : work.moved_triangles) {
    for (const int edge : skin.edges_of[t]) {
      if (work.seen_edges[edge]) continue;
      work.seen_edges[edge] = 1;
      work.moved_edges.push_back(edge);
      look_at(skin, edge, work);
    }
  }
  for (const int edge : work.moved_edges) work.seen_edges[edge] = 0;
  for (const int t : work.moved_triangles) work.seen[t] = 0;
}

}  // namespace

void even_creases(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  if (skin.crease_passes > 0) begin(skin, x, work);
  for (int pass = 0; pass < skin.crease_passes; ++pass) {
    if (pass > 0) look_again(skin, x, work);
    find_sharp(skin, work);
    if (work.sharp_vertices.empty()) return;
    for (const int i : work.sharp_vertices) {
      const int first = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      Point sum{};
      for (int k = first; k < end; ++k) sum += work.displacement[skin.neighbours[k]];
      const double share = 0.5 * work.sharp[i];
      work.before[i] = (1.0 - share) * work.displacement[i] + (share / (end - first)) * sum;
    }
    for (const int i : work.sharp_vertices) {
      if (skin.first_neighbour[i] == skin.first_neighbour[i + 1]) continue;
      work.displacement[i] = work.before[i];
      x[i] = work.carried[i] + work.displacement[i];
    }
  }
}

}  // namespace thew::skin
