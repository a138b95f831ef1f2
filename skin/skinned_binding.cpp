// SPDX-License-Identifier: Apache-2.0
//
// Binds a character's own skin in the rest pose: which part of it is a layer, and its nodes.
#include <algorithm>
#include <cmath>
#include <map>

#include "rig/math.h"
#include "skin/sides.h"
#include "skin/skin_passes.h"
#include "skin/skinned_skin.h"

namespace thew::skin {
namespace {

// Vertices farther from the muscles at rest than this, in multiples of SkinSettings::reach, are no
// nodes of the layer. Chosen by trial.
constexpr double kLayerReach = 2.0;
// Nor are those with less of their weights on limbs: the skin of a trunk, which an arm may go
// through. By trial.
constexpr double kLeastShare = 0.02;
// Weight of the anchors of the layer's rim, which keeps what the weights give: a force of as many
// edges moves it by a ten-thousandth of what it would move one of them.
constexpr double kHeld = 1e4;
constexpr int kMaxDivisions = 6;  // of an edge; bounds the time

Surface surface_of(const SkinnedSkin& skin) {
  TriMesh welded;
  for (const Point& x : skin.rest) welded.vertices.push_back(to_vec(x));
  std::vector<Triangle> all;
  for (const Triangle& t : skin.mesh.triangles) {
    all.push_back({skin.map_back[t[0]], skin.map_back[t[1]], skin.map_back[t[2]]});
  }
  const std::vector<char> doubled = find_doubled(all);
  for (size_t i = 0; i < all.size(); ++i) {
    const Triangle& c = all[i];
    const bool is_flat = c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
    if (!is_flat && !doubled[i]) welded.triangles.push_back(c);
  }
  return make_surface(turned_outwards(welded.vertices, std::move(welded.triangles)),
                      static_cast<int>(skin.rest.size()));
}

// Share of the weights of a vertex on the bodies of limbs.
double share_of(const SkinWeights& weights, const std::vector<char>& limbs, size_t vertex) {
  double share = 0.0;
  for (int k = weights.first[vertex]; k < weights.first[vertex + 1]; ++k) {
    if (limbs[weights.links[weights.link[k]].body]) share += weights.weight[k];
  }
  return share;
}

// Points of a triangle, corners among them, no farther from one another than `spacing`.
std::vector<Vec3> points_of(const Vec3& a, const Vec3& b, const Vec3& c, double spacing) {
  constexpr double kMost = 16.0;  // along an edge; bounds the time
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const int parts = static_cast<int>(std::clamp(std::ceil(longest / spacing), 1.0, kMost));
  std::vector<Vec3> points;
  for (int i = 0; i <= parts; ++i) {
    for (int j = 0; i + j <= parts; ++j) points.push_back(a + (i * (b - a) + j * (c - a)) / parts);
  }
  return points;
}

// The vertices that are near muscles, and the corners of triangles that are near them elsewhere, as
// a coarse character's are.
std::vector<char> find_near(const SkinnedSkin& skin, const std::vector<Collider>& below,
                            int muscles, const std::vector<char>& limbs) {
  const double reach = kLayerReach * skin.settings.reach;
  const auto is_near = [&](const Vec3& p) {
    for (int m = 0; m < muscles; ++m) {
      const Collider& muscle = below[m];
      if (closest_point(*muscle.surface, *muscle.bvh, *muscle.x, p, reach).triangle >= 0)
        return true;
    }
    return false;
  };
  std::vector<char> on_limb(skin.rest.size(), 0), near(skin.rest.size(), 0);
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    if (skin.map_back[i] != static_cast<int>(i)) continue;
    on_limb[i] = share_of(skin.weights, limbs, i) >= kLeastShare;
    near[i] = on_limb[i] && is_near(to_vec(skin.rest[i]));
  }
  for (const Triangle& t : skin.surface.triangles) {
    const auto all = [&](const std::vector<char>& of) { return of[t[0]] && of[t[1]] && of[t[2]]; };
    if (!all(on_limb) || all(near)) continue;
    const std::vector<Vec3> points =
        points_of(to_vec(skin.rest[t[0]]), to_vec(skin.rest[t[1]]), to_vec(skin.rest[t[2]]), reach);
    if (points.size() == 3) continue;
    if (std::any_of(points.begin(), points.end(), is_near)) {
      for (const int v : t) near[v] = 1;
    }
  }
  return near;
}

// Two rings of wide triangles around those, the trunk's too. A triangle meets flesh where all its
// corners are of the layer: without the rings single vertices at the armpit of a coarse character
// met nothing, and lay 6 mm in muscle where an arm is laid to the trunk.
void add_rings(const SkinnedSkin& skin, std::vector<char>& near) {
  constexpr int kRings = 2;  // by trial: with one, 6 mm stayed in one clip of three
  const auto is_wide = [&](const Triangle& t) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, norm(skin.rest[t[k]] - skin.rest[t[(k + 1) % 3]]));
    }
    return longest > skin.settings.reach;
  };
  for (int ring = 0; ring < kRings; ++ring) {
    const std::vector<char> within = near;
    for (const Triangle& t : skin.surface.triangles) {
      if (!(within[t[0]] || within[t[1]] || within[t[2]]) || !is_wide(t)) continue;
      near[t[0]] = near[t[1]] = near[t[2]] = 1;
    }
  }
}

// The triangles of the layer as they are divided, and its nodes.
struct Division {
  std::vector<SkinnedSkin::Node> nodes;
  Points rest;
  std::vector<Triangle> triangles;
  std::vector<int> of;  // by triangle, the triangle of the skin's surface that it is a part of
};

Division undivided(const SkinnedSkin& skin, const std::vector<char>& near) {
  Division out;
  std::vector<int> node(skin.rest.size(), -1);
  const std::vector<Triangle>& all = skin.surface.triangles;
  for (int t = 0; t < static_cast<int>(all.size()); ++t) {
    if (!near[all[t][0]] && !near[all[t][1]] && !near[all[t][2]]) continue;
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const int v = all[t][k];
      if (node[v] < 0) {
        node[v] = static_cast<int>(out.nodes.size());
        out.nodes.push_back({{v, v, v}, {1.0, 0.0, 0.0}});
        out.rest.push_back(skin.rest[v]);
      }
      corners[k] = node[v];
    }
    out.triangles.push_back(corners);
    out.of.push_back(t);
  }
  return out;
}

// The node in the middle between two of one triangle of the skin.
SkinnedSkin::Node middle_of(const SkinnedSkin::Node& a, const SkinnedSkin::Node& b) {
  std::map<int, double> shares;
  for (const SkinnedSkin::Node* one : {&a, &b}) {
    for (int k = 0; k < 3; ++k) {
      if (one->shares[k] > 0.0) shares[one->corners[k]] += 0.5 * one->shares[k];
    }
  }
  const int first = shares.begin()->first;
  SkinnedSkin::Node out{{first, first, first}, {0.0, 0.0, 0.0}};
  int k = 0;
  for (const auto& [vertex, share] : shares) out.corners[k] = vertex, out.shares[k++] = share;
  return out;
}

// Halves all edges that are longer than `longest` (m). Returns whether there was one.
bool divide(double longest, Division& it) {
  std::map<std::array<int, 2>, int> middles;
  const auto middle = [&](int a, int b) {
    const std::array<int, 2> edge = {std::min(a, b), std::max(a, b)};
    if (const auto found = middles.find(edge); found != middles.end()) return found->second;
    int node = -1;
    if (norm(it.rest[a] - it.rest[b]) > longest) {
      node = static_cast<int>(it.nodes.size());
      it.nodes.push_back(middle_of(it.nodes[edge[0]], it.nodes[edge[1]]));
      it.rest.push_back(0.5 * (it.rest[edge[0]] + it.rest[edge[1]]));
    }
    return middles[edge] = node;
  };
  std::vector<Triangle> parts;
  std::vector<int> of;
  bool divided = false;
  for (size_t t = 0; t < it.triangles.size(); ++t) {
    Triangle c = it.triangles[t];
    int m[3];
    for (int k = 0; k < 3; ++k) m[k] = middle(c[k], c[(k + 1) % 3]);
    const int count = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
    const auto add = [&](int a, int b, int d) {
      parts.push_back({a, b, d});
      of.push_back(it.of[t]);
    };
    divided |= count > 0;
    // Turned so that the edge that is halved alone, or that alone is not, is the first.
    int turn = 0;
    while ((count == 1 && m[turn] < 0) || (count == 2 && m[turn] >= 0)) ++turn;
    const int a = c[turn], b = c[(turn + 1) % 3], d = c[(turn + 2) % 3];
    const int ab = m[turn], bd = m[(turn + 1) % 3], da = m[(turn + 2) % 3];
    if (count == 0) {
      add(a, b, d);
    } else if (count == 1) {
      add(a, ab, d), add(ab, b, d);
    } else if (count == 2) {
      add(bd, d, da);
      if (norm(it.rest[a] - it.rest[bd]) <= norm(it.rest[b] - it.rest[da])) {
        add(a, b, bd), add(a, bd, da);
      } else {
        add(a, b, da), add(b, bd, da);
      }
    } else {
      add(a, ab, da), add(ab, b, bd), add(da, bd, d), add(ab, bd, da);
    }
  }
  it.triangles.swap(parts);
  it.of.swap(of);
  return divided;
}

void find_carriers(SkinnedSkin& skin) {
  const SkinWeights& weights = skin.weights;
  for (const SkinnedSkin::Node& node : skin.nodes) {
    std::map<int, double> shares;
    for (int k = 0; k < 3; ++k) {
      if (node.shares[k] <= 0.0) continue;
      for (int i = weights.first[node.corners[k]]; i < weights.first[node.corners[k] + 1]; ++i) {
        shares[weights.link[i]] += node.shares[k] * weights.weight[i];
      }
    }
    std::vector<std::pair<int, double>> carriers(shares.begin(), shares.end());
    std::stable_sort(carriers.begin(), carriers.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    skin.carriers.push_back(std::move(carriers));
  }
}

// A tenth of a muscle's length from either end.
Span span_of(const Points& x) {
  const auto farthest = [&](const Point& from) {
    return *std::max_element(x.begin(), x.end(), [&](const Point& a, const Point& b) {
      return norm(a - from) < norm(b - from);
    });
  };
  const Point begin = farthest(x.front()), end = farthest(begin);
  return {to_vec(0.9 * begin + 0.1 * end), to_vec(0.1 * begin + 0.9 * end)};
}

// Hard pieces keep what the weights give.
void leave_out_hard_pieces(const SkinnedSkin& skin, const std::vector<Collider>& below, int muscles,
                           std::vector<char>& near) {
  const Shell shell = make_shell(skin.surface, static_cast<int>(skin.rest.size()));
  std::vector<Span> spans;
  for (int m = 0; m < muscles; ++m) spans.push_back(span_of(*below[m].x));
  const std::vector<char> hard = find_hard(skin.surface, skin.rest, shell, near, spans);
  for (size_t i = 0; i < near.size(); ++i) near[i] &= shell.piece_of[i] >= 0 && !hard[i];
}

// A map by vertex at the nodes of the layer. Between vertices of which one is negative, so is it.
std::vector<double> at_nodes(const SkinnedSkin& skin, const std::vector<double>& map) {
  std::vector<double> values;
  for (const SkinnedSkin::Node& node : skin.nodes) {
    double value = 0.0, least = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (node.shares[k] <= 0.0) continue;
      value += node.shares[k] * map[node.corners[k]];
      least = std::min(least, map[node.corners[k]]);
    }
    values.push_back(least < 0.0 ? least : value);
  }
  return values;
}

// How much of its fat a node takes: all within reach of a muscle, nothing where the layer ends or
// goes over into the trunk.
double share_of_fat(const SkinnedSkin& skin, const std::vector<Collider>& below, int muscles,
                    const std::vector<char>& limbs, const SkinnedSkin::Node& node, const Vec3& x) {
  constexpr double kTrunk = 0.2, kLimb = 0.4;  // shares of the weights on limbs; chosen by trial
  const double reach = skin.settings.reach;
  double distance = kLayerReach * reach, on_limbs = 0.0;
  for (int m = 0; m < muscles; ++m) {
    const ClosestPoint near =
        closest_point(*below[m].surface, *below[m].bvh, *below[m].x, x, distance);
    if (near.triangle >= 0) distance = std::min(distance, std::max(near.distance, 0.0));
  }
  for (int k = 0; k < 3; ++k) {
    if (node.shares[k] <= 0.0) continue;
    on_limbs += node.shares[k] * share_of(skin.weights, limbs, node.corners[k]);
  }
  return (1.0 - smoothstep(reach, kLayerReach * reach, distance)) *
         smoothstep(kTrunk, kLimb, on_limbs);
}

// Moves the layer's rest shape to its fat over the flesh.
void lift_to_fat(const std::vector<Collider>& below, int muscles, const std::vector<char>& limbs,
                 const std::vector<Triangle>& triangles, const std::vector<double>& fat,
                 SkinnedSkin& skin) {
  if (fat.empty()) return;
  const Points before = skin.layer.rest;
  TriMesh mesh{{}, triangles};
  for (const Point& x : before) mesh.vertices.push_back(to_vec(x));
  std::vector<double> at = at_nodes(skin, fat);
  for (size_t i = 0; i < at.size(); ++i) {  // walls within the body have none
    if (skin.layer.surface.vertex_triangles[i].empty()) at[i] = -1.0;
  }
  shape_fat(below, at, vertex_normals(mesh), skin.layer);
  for (size_t i = 0; i < skin.nodes.size(); ++i) {
    const SkinnedSkin::Node& node = skin.nodes[i];
    const double share =
        node.is_held ? 0.0 : share_of_fat(skin, below, muscles, limbs, node, mesh.vertices[i]);
    skin.lift.push_back(share * (skin.layer.rest[i] - before[i]));
    skin.layer.rest[i] = before[i] + skin.lift[i];
  }
}

void build_layer(const std::vector<Collider>& below, int muscles, const std::vector<char>& limbs,
                 const SkinMaps& maps, SkinnedSkin& skin) {
  std::vector<char> near = find_near(skin, below, muscles, limbs);
  leave_out_hard_pieces(skin, below, muscles, near);
  add_rings(skin, near);
  Division division = undivided(skin, near);
  for (int k = 0; k < kMaxDivisions; ++k) {
    if (!divide(skin.settings.lengths.point_spacing, division)) break;
  }
  skin.nodes = division.nodes;
  if (skin.nodes.empty()) return;
  SkinModel& layer = skin.layer;
  layer.rest = division.rest;
  layer.settings = skin.settings;
  const auto is_seen = [&](int t) {
    const Triangle& c = skin.surface.triangles[t];
    return std::all_of(c.begin(), c.end(), [&](int v) { return near[v] && skin.seen[v]; });
  };
  std::vector<Triangle> outer;
  for (size_t t = 0; t < division.triangles.size(); ++t) {
    if (is_seen(division.of[t])) outer.push_back(division.triangles[t]);
  }
  layer.surface = make_surface(std::move(outer), static_cast<int>(layer.rest.size()));
  std::vector<double> hold;
  for (SkinnedSkin::Node& node : skin.nodes) {
    node.is_held = std::none_of(node.corners.begin(), node.corners.end(),
                                [&](int corner) { return near[corner] != 0; });
    hold.push_back(node.is_held ? kHeld : 0.0);
  }
  lift_to_fat(below, muscles, limbs, division.triangles, maps.fat, skin);
  const std::vector<double> slide = maps.slide.empty() ? maps.slide : at_nodes(skin, maps.slide);
  finish_binding(division.triangles, hold, below, slide, layer);
  find_carriers(skin);
}

}  // namespace

SkinnedSkin bind_skinned(const Character& character, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, int muscles,
                         const std::vector<char>& limbs, const SkinSettings& settings,
                         const SkinMaps& maps) {
  SkinnedSkin skin;
  skin.mesh = character.mesh, skin.weights = character.skin, skin.map_back = character.map_back;
  skin.settings = settings, skin.bodies = rest;
  skin_vertices(skin.weights, skin.mesh, rest, skin.rest);
  skin.surface = surface_of(skin);
  find_seen(skin);
  build_layer(below, muscles, limbs, maps, skin);
  return skin;
}

}  // namespace thew::skin
