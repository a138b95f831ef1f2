// SPDX-License-Identifier: Apache-2.0
//
// Binds a character's own skin in the rest pose: its points, and the sites of the muscles below
// them.
#include <algorithm>
#include <cmath>
#include <set>

#include "rig/math.h"
#include "skin/skinned_skin.h"

namespace thew::skin {
namespace {

constexpr int kMaxPasses = 50;         // bounds the time
constexpr int kMaxCreasePasses = 200;  // bounds the time
// With fewer the mesh is so coarse that it needs its creases to enclose the muscles.
constexpr int kMinCreasePasses = 10;
constexpr int kMinPasses = 4;             // neighbours may be tied to muscles that move apart
constexpr double kMinDeterminant = 1e-6;  // least determinant of a blend that is inverted
constexpr int kMaxAlong = 16;             // most parts of an edge of a triangle; bounds the time

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

Surface surface_of(const SkinnedSkin& skin) {
  TriMesh welded;
  for (const Point& x : skin.rest) welded.vertices.push_back(to_vec(x));
  for (const Triangle& t : skin.mesh.triangles) {
    const Triangle c = {skin.map_back[t[0]], skin.map_back[t[1]], skin.map_back[t[2]]};
    if (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]) welded.triangles.push_back(c);
  }
  if (enclosed_volume(welded) < 0.0) {  // inside out
    for (Triangle& t : welded.triangles) std::swap(t[1], t[2]);
  }
  return make_surface(std::move(welded.triangles), static_cast<int>(skin.rest.size()));
}

void find_edges(SkinnedSkin& skin) {
  const auto is_near = [&](int t) {
    const Triangle& c = skin.surface.triangles[t];
    return skin.near[c[0]] || skin.near[c[1]] || skin.near[c[2]];
  };
  skin.edges_of.resize(skin.surface.triangles.size());
  for (int t = 0; t < static_cast<int>(skin.surface.triangles.size()); ++t) {
    for (const int u : skin.surface.neighbours[t]) {
      if (u < 0 || !is_near(t) || (u < t && is_near(u))) continue;  // the edge is listed already
      for (const int one : {t, u}) {
        skin.edges_of[one].push_back(static_cast<int>(skin.edges.size()));
      }
      skin.edges.push_back({t, u});
    }
  }
}

// Mean length (m) of the edges near the muscles; 0 if there are none.
double mean_edge(const SkinnedSkin& skin) {
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    for (int k = skin.first_neighbour[i]; k < skin.first_neighbour[i + 1]; ++k) {
      if (skin.share[i] <= 0.0) continue;
      sum += to_vec(skin.rest[i] - skin.rest[skin.neighbours[k]]).norm();
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

// Number of smoothing passes for a width (m). n passes, each half the own value and half the mean
// of the neighbours, spread a value over edge sqrt(n / 2); 0 if the mesh is coarser than that.
int passes_over(double width, double edge, int most) {
  if (edge <= 0.0) return 0;
  const double ratio = width / edge;
  return static_cast<int>(std::min(2.0 * ratio * ratio, 1.0 * most));
}

// Adds all vertices, then points between them: those of a triangle lie on a grid whose spacing
// follows from its longest edge. Points on an edge are added by one of its two triangles.
void add_points(SkinnedSkin& skin) {
  const auto add = [&](const Triangle& corners, const std::array<double, 3>& shares) {
    skin.points.push_back({corners, shares});
  };
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    const int v = static_cast<int>(i);
    if (skin.map_back[i] == v) add({v, v, v}, {1.0, 0.0, 0.0});
  }
  for (const Triangle& t : skin.mesh.triangles) {
    const Triangle c = {skin.map_back[t[0]], skin.map_back[t[1]], skin.map_back[t[2]]};
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, to_vec(skin.rest[c[k]] - skin.rest[c[(k + 1) % 3]]).norm());
    }
    const int along = std::min(
        static_cast<int>(std::ceil(longest / skin.settings.lengths.point_spacing)), kMaxAlong);
    for (int i = 0; i < along; ++i) {
      for (int j = 0; i + j <= along; ++j) {
        const int k = along - i - j;
        const int zeros = (i == 0) + (j == 0) + (k == 0);
        const bool theirs =
            (i == 0 && c[1] > c[2]) || (j == 0 && c[2] > c[0]) || (k == 0 && c[0] > c[1]);
        if (zeros == 2 || theirs) continue;
        add(c, {1.0 * i / along, 1.0 * j / along, 1.0 * k / along});
      }
    }
  }
}

// Halves a triangle across its longest side again and again, until all pieces are small enough.
void add_samples(const Vec3 (&corner)[3], const std::array<Vec3, 3>& shares,
                 const SkinnedSkin::SurfaceSite& of, double longest_edge,
                 std::vector<SkinnedSkin::SurfaceSite>& samples) {
  Vec3 position[3];
  for (int k = 0; k < 3; ++k) {
    position[k] = shares[k][0] * corner[0] + shares[k][1] * corner[1] + shares[k][2] * corner[2];
  }
  int longest = 0;
  const auto length = [&](int k) { return (position[(k + 1) % 3] - position[k]).norm(); };
  for (int k = 1; k < 3; ++k) {
    if (length(k) > length(longest)) longest = k;
  }
  if (length(longest) <= longest_edge) {
    const Vec3 middle = (shares[0] + shares[1] + shares[2]) / 3.0;
    samples.push_back({of.muscle, of.triangle, {middle[0], middle[1], middle[2]}});
    return;
  }
  const int a = longest, b = (longest + 1) % 3, c = (longest + 2) % 3;
  const Vec3 half = 0.5 * (shares[a] + shares[b]);
  add_samples(corner, {shares[a], half, shares[c]}, of, longest_edge, samples);
  add_samples(corner, {half, shares[b], shares[c]}, of, longest_edge, samples);
}

void sample_muscles(const std::vector<Collider>& below, SkinnedSkin& skin) {
  const std::array<Vec3, 3> whole = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  for (size_t m = 0; m < below.size(); ++m) {
    const std::vector<Triangle>& triangles = below[m].surface->triangles;
    for (size_t t = 0; t < triangles.size(); ++t) {
      Vec3 corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = to_vec((*below[m].x)[triangles[t][k]]);
      add_samples(corner, whole, {static_cast<int>(m), static_cast<int>(t), {}},
                  skin.settings.lengths.sample_edge, skin.muscle_samples);
    }
  }
}

// Ties each point to the nearest site of a muscle at rest, and drops points that no muscle can
// reach.
void bind_anchors(const std::vector<Affine>& rest, const std::vector<Collider>& below,
                  SkinnedSkin& skin) {
  std::vector<Affine> of_links;
  link_transforms(skin.weights, rest, of_links);
  skin.from_rest.assign(skin.rest.size(), Mat3::Identity());
  std::vector<char> known(skin.rest.size(), 0);  // 2: the blend has no inverse
  std::vector<SkinnedSkin::SkinPoint> anchored;
  for (SkinnedSkin::SkinPoint& point : skin.points) {
    const double reach = skin.settings.reach;
    double nearest = kAnchorReach * reach;
    SkinnedSkin::Anchor& anchor = point.anchor;
    for (size_t m = 0; m < below.size(); ++m) {
      const ClosestPoint near = closest_point(*below[m].surface, *below[m].bvh, *below[m].x,
                                              position_of(point, skin.rest), nearest);
      if (near.triangle < 0) continue;
      nearest = std::abs(near.distance);
      anchor.muscle = static_cast<int>(m), anchor.triangle = near.triangle;
      std::copy(near.barycentric, near.barycentric + 3, anchor.share.begin());
    }
    if (anchor.muscle < 0) continue;
    point.share = 1.0 - smoothstep(0.5 * reach, reach, nearest);
    anchor.out = position_of(point, skin.rest) - position_of(anchor, below);
    for (const int v : point.corners) {
      if (known[v] == 0) {
        const Mat3 blend = blended_transform(skin.weights, of_links, v).linear();
        known[v] = std::abs(blend.determinant()) < kMinDeterminant ? 2 : 1;
        if (known[v] == 1) skin.from_rest[v] = blend.inverse();
      }
      if (known[v] == 2) anchor.muscle = -1;
    }
    if (anchor.muscle >= 0) anchored.push_back(point);
  }
  skin.points.swap(anchored);
}

// The marked vertices and all that edges lead to from them, in so many steps.
std::vector<int> with_rings(const SkinnedSkin& skin, std::vector<char> marked, int rings) {
  std::vector<int> all;
  for (size_t i = 0; i < marked.size(); ++i) {
    if (marked[i]) all.push_back(static_cast<int>(i));
  }
  for (size_t from = 0; rings > 0; --rings) {
    const size_t end = all.size();
    for (; from < end; ++from) {
      for (int k = skin.first_neighbour[all[from]]; k < skin.first_neighbour[all[from] + 1]; ++k) {
        const int other = skin.neighbours[k];
        if (marked[other]) continue;
        marked[other] = 1;
        all.push_back(other);
      }
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

void find_reached(SkinnedSkin& skin) {
  std::vector<char> displaced(skin.rest.size(), 0);
  for (const SkinnedSkin::SkinPoint& point : skin.points) {
    for (int k = 0; k < 3; ++k) {
      if (point.share > 0.0 && point.shares[k] > 0.0) displaced[point.corners[k]] = 1;
    }
  }
  skin.reached = with_rings(skin, displaced, skin.passes);
  skin.near_vertices = with_rings(skin, skin.near, 0);
  skin.round_near = with_rings(skin, skin.near, 1);
}

}  // namespace

SkinnedSkin bind_skinned(const TriMesh& mesh, const std::vector<int>& map_back,
                         const SkinWeights& weights, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, const SkinSettings& settings) {
  SkinnedSkin skin;
  skin.mesh = mesh, skin.weights = weights, skin.map_back = map_back, skin.settings = settings;
  skin.bodies = rest;
  skin_vertices(weights, mesh, rest, skin.rest);
  find_neighbours(skin);
  skin.surface = surface_of(skin);
  find_seen(skin);
  add_points(skin);
  bind_anchors(rest, below, skin);
  sample_muscles(below, skin);
  find_rest_lacks(below, skin);
  skin.share.assign(skin.rest.size(), 0.0);
  for (const SkinnedSkin::SkinPoint& point : skin.points) {
    if (point.corners[0] == point.corners[1]) skin.share[point.corners[0]] = point.share;
  }
  skin.near.assign(skin.rest.size(), 0);
  for (const SkinnedSkin::SkinPoint& point : skin.points) {
    for (const int v : point.corners) skin.near[v] = 1;
  }
  find_edges(skin);
  const double edge = mean_edge(skin);
  skin.passes = std::max(passes_over(settings.lengths.smoothing_width, edge, kMaxPasses),
                         passes_over(settings.lengths.max_spread, edge, kMinPasses));
  skin.crease_passes = passes_over(settings.lengths.crease_width, edge, kMaxCreasePasses);
  if (skin.crease_passes < kMinCreasePasses) skin.crease_passes = 0;
  find_reached(skin);
  return skin;
}

}  // namespace thew::skin
