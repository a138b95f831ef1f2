// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/crossings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "skin/surface/surface.h"
#include "tools/inspect/exact_predicates.h"

namespace thew::tools {
namespace {

using Kind = BakeMesh::Kind;

constexpr int kRays = 5;
// Of its edges a skin may lack a neighbour at so many and still tell inside from outside.
constexpr double kMostOpen = 0.1;

// Exact tests of one frame, of all and of each triangle: surfaces have some thirty each, and where
// all nodes lie in one place each triangle meets all others.
constexpr std::size_t kMostTests = 20000, kMostTestsEach = 100;

/// A triangle with its box.
struct Item {
  int mesh, triangle;
  Vec3 low, high;
};

int layer_pair(Kind a, Kind b) {
  const auto are = [&](Kind x, Kind y) { return (a == x && b == y) || (a == y && b == x); };
  if (are(Kind::kBone, Kind::kMuscle) || are(Kind::kProp, Kind::kMuscle)) return 0;
  if (are(Kind::kMuscle, Kind::kMuscle)) return 1;
  if (are(Kind::kSkin, Kind::kMuscle)) return 2;
  if (are(Kind::kSkin, Kind::kBone)) return 3;
  return are(Kind::kSkin, Kind::kSkin) ? 4 : -1;
}

Corners corners(const std::vector<Vec3>& x, const Triangle& t) {
  return {x[t[0]], x[t[1]], x[t[2]]};
}

bool share_vertex(const Triangle& s, const Triangle& t) {
  return std::any_of(s.begin(), s.end(),
                     [&](int i) { return std::find(t.begin(), t.end(), i) != t.end(); });
}

bool is_edge(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// The share of edges that lack a neighbour.
double open_share(const std::vector<Triangle>& triangles) {
  struct Edge {
    int a, b, way;  // a < b; +1 one way, -1 the other
    auto ends() const { return std::pair(a, b); }
  };
  std::vector<Edge> edges;
  for (const Triangle& t : triangles) {
    if (is_edge(t)) continue;
    for (int i = 0; i < 3; ++i) {
      const int a = t[i], b = t[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& e, const Edge& f) { return e.ends() < f.ends(); });
  int open = 0, all = 0;
  for (std::size_t i = 0; i < edges.size(); ++all) {
    int balance = 0;
    for (const auto ends = edges[i].ends(); i < edges.size() && edges[i].ends() == ends; ++i) {
      balance += edges[i].way;
    }
    open += balance != 0;
  }
  return all == 0 ? 1.0 : static_cast<double>(open) / all;
}

/// A frame's meshes.
struct Layers {
  const std::vector<BakeMesh>& meshes;
  const std::vector<std::vector<Vec3>>& x;
  std::vector<std::vector<Triangle>> triangles;
  std::vector<double> reach;  // m, of a muscle's attachments
};

Layers layers_of(const std::vector<BakeMesh>& meshes,
                 const std::vector<std::vector<Vec3>>& positions) {
  Layers layers{meshes, positions, {}, {}};
  for (const BakeMesh& mesh : meshes) {
    layers.triangles.push_back(joined_triangles(mesh.rest));
    layers.reach.push_back(kAttachmentReach * std::cbrt(std::abs(enclosed_volume(mesh.rest))));
  }
  return layers;
}

/// Of bone and muscle where the tendon enters its bone.
bool is_attached(const Vec3& p, int a, int b, const Layers& layers) {
  if (layer_pair(layers.meshes[a].kind, layers.meshes[b].kind) != 0) return false;
  const int m = layers.meshes[a].kind == Kind::kMuscle ? a : b;
  const std::vector<Vec3>& x = layers.x[m];
  return std::min((p - x.front()).norm(), (p - x.back()).norm()) <= layers.reach[m];
}

/// Where the edges of s pass through t.
void add_passages(const Corners& s, const Corners& t, std::vector<Vec3>& places) {
  const auto& [a, b, c] = t;
  const Vec3 normal = (b - a).cross(c - a);
  for (int k = 0; k < 3; ++k) {
    const Vec3 &p = s[k], &q = s[(k + 1) % 3];
    if (orientation(a, b, c, p) * orientation(a, b, c, q) >= 0) continue;
    const int u = orientation(p, q, a, b), v = orientation(p, q, b, c), w = orientation(p, q, c, a);
    if (std::min({u, v, w}) < 0 && std::max({u, v, w}) > 0) continue;
    const double above = normal.dot(p - a), below = normal.dot(a - q);
    places.push_back(p + above / (above + below) * (q - p));
  }
}

/// The ends of what two triangles that meet have in common; all their corners where they touch.
std::vector<Vec3> ends_of_crossing(const Corners& s, const Corners& t) {
  std::vector<Vec3> places;
  add_passages(s, t, places);
  add_passages(t, s, places);
  if (places.size() < 2) places = {s[0], s[1], s[2], t[0], t[1], t[2]};
  return places;
}

std::vector<Item> items_along_y(const Layers& layers) {
  std::vector<Item> items;
  for (std::size_t m = 0; m < layers.triangles.size(); ++m) {
    const auto& triangles = layers.triangles[m];
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto [a, b, c] = corners(layers.x[m], triangles[t]);
      items.push_back({static_cast<int>(m), static_cast<int>(t), a.cwiseMin(b).cwiseMin(c),
                       a.cwiseMax(b).cwiseMax(c)});
    }
  }
  std::stable_sort(items.begin(), items.end(),
                   [](const Item& a, const Item& b) { return a.low.y() < b.low.y(); });
  return items;
}

void count_pair(const Item& a, const Item& b, const Layers& layers, Crossings& found) {
  const auto& x = layers.x;
  const auto& triangles = layers.triangles;
  const Triangle &s = triangles[a.mesh][a.triangle], &t = triangles[b.mesh][b.triangle];
  if (a.mesh == b.mesh && share_vertex(s, t)) return;
  const Corners first = corners(x[a.mesh], s), second = corners(x[b.mesh], t);
  if (!triangles_meet(first, second)) return;
  // The whole of it has to be there: a crossing that leaves the patch is no attachment.
  const auto attached = [&](const Vec3& p) { return is_attached(p, a.mesh, b.mesh, layers); };
  const std::vector<Vec3> ends = ends_of_crossing(first, second);
  if (std::all_of(ends.begin(), ends.end(), attached)) {
    ++found.attached;
    return;
  }
  if (found.pairs++ > 0) return;
  found.mesh_a = a.mesh, found.triangle_a = a.triangle;
  found.mesh_b = b.mesh, found.triangle_b = b.triangle;
  found.at = first[0];
}

// Sweep along y, the arm's long axis.
void count_pairs(const Layers& layers, std::array<Crossings, kLayerPairs.size()>& found) {
  const std::vector<Item> items = items_along_y(layers);
  const std::size_t most = kMostTests + kMostTestsEach * items.size();
  std::size_t tests = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Item& a = items[i];
    for (std::size_t k = i + 1; k < items.size() && items[k].low.y() <= a.high.y(); ++k) {
      const Item& b = items[k];
      const bool apart = (b.low.x() > a.high.x()) | (a.low.x() > b.high.x()) |
                         (b.low.z() > a.high.z()) | (a.low.z() > b.high.z());
      if (apart) continue;
      const int pair = layer_pair(layers.meshes[a.mesh].kind, layers.meshes[b.mesh].kind);
      if (pair >= 0 && ++tests > most) {
        throw Error(ErrorCode::kInput, "its triangles lie upon each other in heaps, about " +
                                           layers.meshes[a.mesh].name +
                                           ", and are not counted; bake again");
      }
      if (pair >= 0) count_pair(a, b, layers, found[pair]);
    }
  }
}

/// Triangles of leaves whose boxes meet the box, ascending.
void triangles_in_box(const Bvh& bvh, const Vec3& low, const Vec3& high, std::vector<int>& found) {
  found.clear();
  std::vector<int> stack(bvh.order.empty() ? 0 : 1, 0);
  while (!stack.empty()) {
    const Bvh::Node& node = bvh.nodes[stack.back()];
    stack.pop_back();
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart = apart || node.lo[k] > high[k] || node.hi[k] < low[k];
    if (apart) continue;
    found.insert(found.end(), bvh.order.begin() + node.first,
                 bvh.order.begin() + node.first + node.count);
    if (node.count == 0) stack.insert(stack.end(), {node.first, node.first + 1});
  }
  std::sort(found.begin(), found.end());
}

// Distances of its own, not those of skin/surface: what is checked here must not check itself.
double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length = d.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * d).norm();
}

double triangle_distance(const Vec3& p, const Corners& t) {
  const auto& [a, b, c] = t;
  const Vec3 normal = (b - a).cross(c - a);
  const auto within = [&](const Vec3& u, const Vec3& v) {
    return normal.dot((v - u).cross(p - u)) >= 0.0;
  };
  if (normal.squaredNorm() > 0 && within(a, b) && within(b, c) && within(c, a)) {
    return std::abs(normal.dot(p - a)) / normal.norm();
  }
  return std::min(
      {segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
}

double surface_distance(const Vec3& p, const std::vector<Vec3>& x,
                        const std::vector<Triangle>& triangles) {
  double best = std::numeric_limits<double>::max();
  for (const Triangle& t : triangles) best = std::min(best, triangle_distance(p, corners(x, t)));
  return best;
}

/// Triangles by slabs of y, so that a ray across y meets few of them.
struct Slabs {
  static constexpr int kCount = 128;
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  std::array<std::vector<Triangle>, kCount> triangles;

  int at(double y) const {
    const double extent = high.y() - low.y();
    const double place = extent > 0 ? kCount * ((y - low.y()) / extent) : 0.0;
    return std::clamp(static_cast<int>(place), 0, kCount - 1);
  }
};

Slabs make_slabs(const std::vector<Vec3>& x, const std::vector<Triangle>& triangles) {
  Slabs slabs;
  for (const Triangle& t : triangles) {
    if (is_edge(t)) continue;
    for (const int i : t)
      slabs.low = slabs.low.cwiseMin(x[i]), slabs.high = slabs.high.cwiseMax(x[i]);
  }
  for (const Triangle& t : triangles) {
    if (is_edge(t)) continue;
    const auto [least, most] = std::minmax({x[t[0]].y(), x[t[1]].y(), x[t[2]].y()});
    for (int i = slabs.at(least); i <= slabs.at(most); ++i) slabs.triangles[i].push_back(t);
  }
  return slabs;
}

/// How often the segment pq leaves the surfaces less how often it enters them, or nothing where it
/// touches an edge or a corner, or p lies on one.
std::optional<int> count_ray(const Vec3& p, const Vec3& q, const std::vector<Vec3>& x,
                             const std::vector<Triangle>& triangles) {
  const Vec3 low = p.cwiseMin(q), high = p.cwiseMax(q);
  const auto is_beside = [&](const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
    return std::min({a[axis], b[axis], c[axis]}) > high[axis] ||
           std::max({a[axis], b[axis], c[axis]}) < low[axis];
  };
  int count = 0;
  for (const Triangle& t : triangles) {
    const Vec3 &a = x[t[0]], &b = x[t[1]], &c = x[t[2]];
    if (is_beside(a, b, c, 2) || is_beside(a, b, c, 1) || is_beside(a, b, c, 0)) continue;
    const int sp = orientation(a, b, c, p), sq = orientation(a, b, c, q);
    if (sp * sq > 0) continue;
    const int u = orientation(p, q, a, b), v = orientation(p, q, b, c), w = orientation(p, q, c, a);
    if (std::min({u, v, w}) < 0 && std::max({u, v, w}) > 0) continue;
    if (sp * sq * u * v * w == 0) return {};
    count += sp;
  }
  return count;
}

/// By the winding of `rays` rays, the majority of which decides: one is enough where the mesh is
/// closed, and shapes may overlap.
bool is_inside_slabs(const Vec3& p, const Slabs& slabs, const std::vector<Vec3>& x, int rays) {
  if ((p.array() < slabs.low.array()).any() || (p.array() > slabs.high.array()).any()) return false;
  // Rays across y; one that grazes a corner is turned a little, and stays in the plane of its y.
  const double reach = 2.0 * (slabs.high - slabs.low).norm() + 1e-3;
  const std::array<Vec3, kRays> ways = {Vec3(1, 0, 0), Vec3(-1, 0, 0.31), Vec3(0.23, 0, 1),
                                        Vec3(-0.17, 0, -1), Vec3(0.71, 0, -0.67)};
  int inside = 0, counted = 0;
  for (int ray = 0; ray < rays; ++ray) {
    std::optional<int> count;
    for (int turn = 0; turn < 16 && !count; ++turn) {
      const Vec3 q =
          p + reach * (ways[ray] + 0.0377 * turn * Vec3(-ways[ray].z(), 0, ways[ray].x()));
      count = count_ray(p, q, x, slabs.triangles[slabs.at(p.y())]);
    }
    if (!count) continue;
    ++counted;
    inside += *count != 0;
  }
  return 2 * inside > counted;  // on the surface itself: no
}

/// The vertices of mesh `a` inside mesh `b`, or outside it where b is the skin.
void measure_depth(int a, int b, const Slabs& slabs, int rays, const Layers& layers,
                   Crossings& found) {
  const auto& [meshes, x, triangles, reach] = layers;
  const bool outside = meshes[b].kind == Kind::kSkin;
  std::vector<char> used(x[a].size(), 0);
  for (const Triangle& t : triangles[a]) {
    for (const int i : t) used[i] = 1;
  }
  for (std::size_t i = 0; i < x[a].size(); ++i) {
    const Vec3& p = x[a][i];
    if (!used[i] || is_inside_slabs(p, slabs, x[b], rays) == outside) continue;
    if (is_attached(p, a, b, layers)) continue;
    const double depth = surface_distance(p, x[b], triangles[b]);
    if (depth <= found.depth) continue;
    found.depth = depth, found.deep_at = p;
    found.deep_mesh = a, found.deep_vertex = static_cast<int>(i), found.deep_in = b;
  }
}

}  // namespace

SelfCrossings find_self_crossings(const TriMesh& mesh) {
  // A sound mesh takes some 40 a triangle: two millions; one in a heap would take for ever.
  constexpr int kMostWork = 80'000'000, kTest = 16;
  const std::vector<Triangle>& triangles = mesh.triangles;
  const Surface surface = make_surface(triangles, static_cast<int>(mesh.vertices.size()));
  const Bvh bvh = build_bvh(surface, to_points(mesh.vertices));
  SelfCrossings found;
  int work = 0;
  std::vector<int> near;
  for (int i = 0; i < static_cast<int>(triangles.size()); ++i) {
    const Corners one = corners(mesh.vertices, triangles[i]);
    triangles_in_box(bvh, one[0].cwiseMin(one[1]).cwiseMin(one[2]),
                     one[0].cwiseMax(one[1]).cwiseMax(one[2]), near);
    for (const int k : near) {
      if (++work > kMostWork) {
        found.all = false;
        return found;
      }
      if (k <= i || share_vertex(triangles[i], triangles[k])) continue;
      const Corners two = corners(mesh.vertices, triangles[k]);
      work += kTest;
      if (!triangles_meet(one, two) || found.pairs++ > 0) continue;
      found.first = i, found.second = k;
      const std::vector<Vec3> ends = ends_of_crossing(one, two);
      for (const Vec3& end : ends) found.at += end / static_cast<double>(ends.size());
    }
  }
  return found;
}

bool is_inside(const Vec3& p, const std::vector<Vec3>& vertices,
               const std::vector<Triangle>& triangles) {
  return is_inside_slabs(p, make_slabs(vertices, triangles), vertices, 1);
}

namespace {

// Exact tests of triangles without any size take their longest way, each with all others.
void refuse_heaps(const std::vector<BakeMesh>& meshes,
                  const std::vector<std::vector<Vec3>>& positions) {
  constexpr double kHeap = 1e-9;  // m
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const std::vector<Vec3>& x = positions[m];
    const auto in_place = [&](const Vec3& p) { return (p - x[0]).cwiseAbs().maxCoeff() < kHeap; };
    if (x.empty() || !std::all_of(x.begin(), x.end(), in_place)) continue;
    throw Error(ErrorCode::kInput,
                "all nodes of " + meshes[m].name +
                    " lie in one place, and what it crosses is not counted; bake "
                    "again");
  }
}

}  // namespace

std::array<Crossings, kLayerPairs.size()> count_crossings(
    const std::vector<BakeMesh>& meshes, const std::vector<std::vector<Vec3>>& positions) {
  refuse_heaps(meshes, positions);
  std::array<Crossings, kLayerPairs.size()> found;
  count_pairs(layers_of(meshes, positions), found);
  return found;
}

std::array<Crossings, kLayerPairs.size()> find_crossings(
    const std::vector<BakeMesh>& meshes, const std::vector<std::vector<Vec3>>& positions) {
  refuse_heaps(meshes, positions);
  std::array<Crossings, kLayerPairs.size()> found;
  const Layers layers = layers_of(meshes, positions);
  count_pairs(layers, found);
  for (std::size_t b = 0; b < meshes.size(); ++b) {
    const double open = open_share(layers.triangles[b]);
    if (open > (meshes[b].kind == Kind::kSkin ? kMostOpen : 0.0)) continue;
    const Slabs slabs = make_slabs(positions[b], layers.triangles[b]);
    for (std::size_t a = 0; a < meshes.size(); ++a) {
      const int pair = layer_pair(meshes[a].kind, meshes[b].kind);
      if (a == b || pair < 0) continue;
      measure_depth(static_cast<int>(a), static_cast<int>(b), slabs, open > 0.0 ? kRays : 1, layers,
                    found[pair]);
    }
  }
  return found;
}

}  // namespace thew::tools
