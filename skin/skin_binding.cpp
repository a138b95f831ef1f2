// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "muscles/volume.h"
#include "skin/flesh_level.h"
#include "skin/skin_layer.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

struct Edges {
  std::vector<std::array<int, 2>> nodes;
  std::vector<double> weights;
  double mean_length = 0.0;  // m
};

// Edges with weights of half the sum of the cotangents of the two opposite angles (Pinkall and
// Polthier 1993). With these the Laplacian of evenly stretched skin is zero, whatever the
// directions of the diagonals. Weights are clamped to stay positive.
Edges weighted_edges(const SkinModel& model, const std::vector<Triangle>& triangles) {
  constexpr double kLeast = 0.02, kMost = 5.0;  // chosen by trial
  std::map<std::array<int, 2>, double> weights;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[(k + 1) % 3], b = t[(k + 2) % 3];
      const Vec3 p = to_vec(model.rest[t[k]]);
      const Vec3 u = to_vec(model.rest[a]) - p, v = to_vec(model.rest[b]) - p;
      const double cross = u.cross(v).norm();
      weights[{std::min(a, b), std::max(a, b)}] += cross > 0.0 ? 0.5 * u.dot(v) / cross : 0.0;
    }
  }
  Edges edges;
  for (const auto& [nodes, weight] : weights) {
    edges.nodes.push_back(nodes);
    edges.weights.push_back(std::clamp(weight, kLeast, kMost));
    edges.mean_length += to_vec(model.rest[nodes[0]] - model.rest[nodes[1]]).norm();
  }
  edges.mean_length /= static_cast<double>(edges.nodes.size());
  return edges;
}

// The matrix Laplacian + diagonal; `stiffness` of an edge by its two nodes.
template <typename Stiffness>
Skyline laplacian(const Edges& edges, const Stiffness& stiffness,
                  const std::vector<double>& diagonal) {
  const int nodes = static_cast<int>(diagonal.size());
  Skyline matrix = make_skyline(nodes, edges.nodes, std::vector<char>(nodes, 0));
  for (size_t e = 0; e < edges.nodes.size(); ++e) {
    const auto& [a, b] = edges.nodes[e];
    const double k = stiffness(a, b) * edges.weights[e];
    add_entry(matrix, a, a, k);
    add_entry(matrix, b, b, k);
    add_entry(matrix, a, b, -k);
  }
  for (int i = 0; i < nodes; ++i) add_entry(matrix, i, i, diagonal[i]);
  return matrix;
}

SkylineFactor factor_of(const Skyline& matrix) {
  SkylineFactor factor;
  factorise(matrix, std::vector<double>(matrix.size(), 0.0), factor);
  return factor;
}

// For each node the body of its nearest bone, and for each body how far its nodes are from it.
struct Nearest {
  std::vector<int> body;
  std::vector<double> mean_distance;  // m
};

Nearest nearest_bodies(const SkinModel& model, const std::vector<Collider>& below,
                       const std::vector<int>& bodies_of, int bodies) {
  Nearest nearest;
  nearest.mean_distance.assign(bodies, 0.0);
  std::vector<int> count(bodies, 0);
  for (const Point& x : model.rest) {
    double best = model.settings.lengths.farthest_bone;
    int body = 0;
    for (size_t j = 0; j < below.size(); ++j) {
      if (bodies_of[j] < 0) continue;
      const ClosestPoint near =
          closest_point(*below[j].surface, *below[j].bvh, *below[j].x, to_vec(x), best);
      if (near.triangle < 0 || std::abs(near.distance) >= best) continue;
      best = std::abs(near.distance);
      body = bodies_of[j];
    }
    nearest.body.push_back(body);
    nearest.mean_distance[body] += best;
    ++count[body];
  }
  for (int b = 0; b < bodies; ++b) nearest.mean_distance[b] /= std::max(count[b], 1);
  return nearest;
}

// Keeps the four largest shares of a node, scaled to sum to 1.
void keep_largest(const std::vector<double>& share, SkinModel& model) {
  const int bodies = static_cast<int>(share.size()), kept = std::min(4, bodies);
  std::vector<int> order(bodies);
  for (int b = 0; b < bodies; ++b) order[b] = b;
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return share[a] > share[b]; });
  std::array<int, 4> body{-1, -1, -1, -1};
  std::array<double, 4> part{};
  double sum = 0.0;
  for (int k = 0; k < kept; ++k) sum += share[order[k]];
  for (int k = 0; k < kept; ++k) {
    body[k] = order[k];
    part[k] = share[order[k]] / sum;
  }
  model.bodies.push_back(body);
  model.shares.push_back(part);
}

// Each node belongs to its nearest body at first. These shares are diffused twice over the surface
// by share + l^2/2 Laplacian(share) = share before, so that the transition between bodies spans
// about the radius l of the limb on either side: of an arm at the elbow, of a finger at its joints.
void diffuse_shares(const Nearest& nearest, const Edges& edges, int bodies, SkinModel& model) {
  const int nodes = static_cast<int>(model.rest.size());
  const auto spread = [&](int a, int b) {
    const double l =
        0.5 * (nearest.mean_distance[nearest.body[a]] + nearest.mean_distance[nearest.body[b]]) /
        edges.mean_length;
    return 0.5 * l * l;
  };
  const Skyline matrix = laplacian(edges, spread, std::vector<double>(nodes, 1.0));
  const SkylineFactor factor = factor_of(matrix);
  std::vector<std::vector<double>> share(nodes, std::vector<double>(bodies, 0.0));
  constexpr int kLanes = 8;
  for (int first = 0; first < bodies; first += kLanes) {
    PointPairs rows(nodes, PointPair{});
    for (int i = 0; i < nodes; ++i) {
      const int lane = nearest.body[matrix.order[i]] - first;
      if (lane >= 0 && lane < kLanes) rows[i][lane] = 1.0;
    }
    solve(matrix, factor, rows);
    solve(matrix, factor, rows);
    for (int i = 0; i < nodes; ++i) {
      for (int b = first; b < std::min(bodies, first + kLanes); ++b) {
        share[matrix.order[i]][b] = std::max(rows[i][b - first], 0.0);
      }
    }
  }
  for (const std::vector<double>& of_node : share) keep_largest(of_node, model);
}

void measure_fat(const std::vector<Collider>& below, SkinModel& model) {
  const size_t nodes = model.rest.size();
  FleshPlanes planes;
  planes.planes.resize(nodes);
  planes.count.resize(nodes);
  std::vector<int> hints(nodes * (below.size() + 1), -1);
  const double bridging = model.settings.bridging, reach = model.settings.lengths.fat_reach;
  for (size_t i = 0; i < nodes; ++i) {
    const int node = static_cast<int>(i);
    const Vec3 x = to_vec(model.rest[i]);
    find_flesh(below, model.rest, {1, {node}}, reach, bridging,
               model.settings.lengths.least_direction, hints, planes);
    const FleshValue flesh = flesh_value(planes, node, x, bridging);
    model.fat.push_back(flesh.found ? flesh.level : reach);
    // A node that is nearer than the thickness at rest may stay as near, but not inside.
    const double room = flesh.found ? std::max(flesh.nearest, 0.0) : model.settings.thickness;
    model.least.push_back(std::min(model.settings.thickness, room));
  }
}

double anchoring(const Edges& edges, const SkinModel& model) {
  const double ratio = edges.mean_length / model.settings.lengths.anchor_length;
  return ratio * ratio;
}

void build_elasticity(const Edges& edges, SkinModel& model) {
  const double stiffness = 2.0 * model.settings.smoothing;
  std::vector<std::vector<std::pair<int, double>>> across(model.rest.size());
  for (size_t e = 0; e < edges.nodes.size(); ++e) {
    const auto& [a, b] = edges.nodes[e];
    across[a].push_back({b, stiffness * edges.weights[e]});
    across[b].push_back({a, stiffness * edges.weights[e]});
  }
  model.first_neighbour.push_back(0);
  for (const auto& neighbours : across) {
    for (const auto& [node, weight] : neighbours) {
      model.neighbours.push_back(node);
      model.weights.push_back(weight);
    }
    model.first_neighbour.push_back(static_cast<int>(model.neighbours.size()));
  }
  for (size_t i = 0; i < model.rest.size(); ++i) {
    double weight = model.anchor[i] + (model.stick.empty() ? 0.0 : model.stick[i]);
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      weight += model.weights[k];
    }
    model.weight.push_back(weight);
  }
  std::vector<double> held = model.anchor;
  for (size_t i = 0; i < model.stick.size(); ++i) held[i] += model.stick[i];
  model.matrix = laplacian(
      edges, [&](int, int) { return stiffness; }, held);
  model.factor = factor_of(model.matrix);
}

// How deep each node of the flesh lies below the skin at rest, where that is less than it keeps
// elsewhere.
void find_rest_covers(const std::vector<Collider>& below, SkinModel& model) {
  const Lengths& lengths = model.settings.lengths;
  const Bvh bvh = build_bvh(model.surface, model.rest);
  for (const Collider& flesh : below) {
    for (const Point& x : *flesh.x) {
      const ClosestPoint near =
          closest_point(model.surface, bvh, model.rest, to_vec(x), lengths.fat_reach);
      model.cover.push_back(near.triangle < 0 ? lengths.cover
                                              : std::min(lengths.cover, -near.distance));
    }
  }
}

void find_rest_crossings(SkinModel& model) {
  const Bvh bvh = build_bvh(model.surface, model.rest);
  model.crosses_at_rest.assign(model.surface.triangles.size(), 0);
  for (const auto& pair :
       crossing_triangles(model.surface, bvh, model.rest, model.surface, bvh, model.rest)) {
    for (const int t : pair) model.crosses_at_rest[t] = 1;
  }
}

}  // namespace

SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings, const SkinMaps& maps) {
  SkinModel model;
  model.surface = make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size()));
  model.rest = to_points(mesh.vertices);
  model.bind_pose = bind_pose;
  model.settings = settings;
  shape_fat(below, maps.fat, vertex_normals(mesh), model);
  model.volume = enclosed_volume(model.rest, model.surface.triangles);
  const Edges edges = weighted_edges(model, model.surface.triangles);
  diffuse_shares(nearest_bodies(model, below, bodies_of, skeleton.size()), edges, skeleton.size(),
                 model);
  measure_fat(below, model);
  // Skin is anchored where it belongs to one body alone, and slides over the joints.
  for (const auto& share : model.shares) {
    const double pure = std::max(2.0 * share[0] - 1.0, 0.0);
    model.anchor.push_back(anchoring(edges, model) * pure * pure);
  }
  bind_slide(below, maps.slide, edges.mean_length, model);
  build_elasticity(edges, model);
  find_wall_levels(model);
  return model;
}

void finish_binding(const std::vector<Triangle>& triangles, const std::vector<double>& hold,
                    const std::vector<Collider>& below, const std::vector<double>& slide,
                    SkinModel& model) {
  const Edges edges = weighted_edges(model, triangles);
  for (const double weight : hold) model.anchor.push_back(anchoring(edges, model) + weight);
  measure_fat(below, model);
  bind_slide(below, slide, edges.mean_length, model);
  build_elasticity(edges, model);
  find_wall_levels(model);
  find_rest_covers(below, model);
  find_rest_crossings(model);
}

}  // namespace thew::skin
