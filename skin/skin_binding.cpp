// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "skin/skin_layer.h"

namespace thew {
namespace {

constexpr double kFarthestBone = 1.0;   // m
static double kAnchorLength = getenv("AL") ? atof(getenv("AL")) : 0.12;  // m over which a held patch draws its neighbours along
constexpr double kFatReach = 0.03;      // m beyond which flesh does not carry the skin

std::vector<std::array<int, 2>> edges_of(const Surface& surface) {
  std::vector<std::array<int, 2>> edges;
  for (size_t t = 0; t < surface.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      const int across = surface.neighbours[t][k];
      if (across < 0 || static_cast<int>(t) < across)
        edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  return edges;
}

double mean_edge(const SkinModel& model) {
  double sum = 0.0;
  for (const auto& [a, b] : model.edges)
    sum += (to_vec(model.rest[a]) - to_vec(model.rest[b])).norm();
  return sum / static_cast<double>(model.edges.size());
}

// stiffness * graph Laplacian + diagonal.
Skyline laplacian(const SkinModel& model, double stiffness, const std::vector<double>& diagonal) {
  const int nodes = static_cast<int>(model.rest.size());
  Skyline matrix = make_skyline(nodes, model.edges, std::vector<char>(nodes, 0));
  for (size_t e = 0; e < model.edges.size(); ++e) {
    const auto& [a, b] = model.edges[e];
    const double k = stiffness * model.edge_weights[e];
    add_entry(matrix, a, a, k);
    add_entry(matrix, b, b, k);
    add_entry(matrix, a, b, -k);
  }
  for (int i = 0; i < nodes; ++i) add_entry(matrix, i, i, diagonal[i]);
  return matrix;
}

// Half the cotangents of the angles across each edge: such a Laplacian leaves evenly stretched skin
// even, whichever way the mesh's diagonals run (Pinkall and Polthier 1993). Kept positive.
std::vector<double> cotangent_weights(const SkinModel& model) {
  constexpr double kLeast = 0.02, kMost = 5.0;
  std::vector<double> weights(model.edges.size(), 0.0);
  std::map<std::array<int, 2>, size_t> index;
  for (size_t e = 0; e < model.edges.size(); ++e) index[model.edges[e]] = e;
  for (const Triangle& t : model.surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[(k + 1) % 3], b = t[(k + 2) % 3];
      const Vec3 u = to_vec(model.rest[a]) - to_vec(model.rest[t[k]]);
      const Vec3 v = to_vec(model.rest[b]) - to_vec(model.rest[t[k]]);
      const double cross = u.cross(v).norm();
      if (cross > 0.0) weights[index[{std::min(a, b), std::max(a, b)}]] += 0.5 * u.dot(v) / cross;
    }
  }
  for (double& w : weights) w = std::clamp(w, kLeast, kMost);
  return weights;
}

// Distance of each node from the bones of each body, and the body that is nearest.
struct Nearest {
  std::vector<int> body;
  double mean_distance = 0.0;
};

Nearest nearest_bodies(const SkinModel& model, const std::vector<Collider>& below,
                       const std::vector<int>& bodies_of) {
  Nearest nearest;
  for (const Row& x : model.rest) {
    double best = kFarthestBone;
    int body = 0, hint = -1;
    for (size_t j = 0; j < below.size(); ++j) {
      if (bodies_of[j] < 0) continue;
      const ClosestPoint near =
          closest_point(*below[j].surface, *below[j].bvh, *below[j].x, to_vec(x), best, hint);
      if (near.triangle < 0 || std::abs(near.distance) >= best) continue;
      best = std::abs(near.distance);
      body = bodies_of[j];
    }
    nearest.body.push_back(body);
    nearest.mean_distance += best / static_cast<double>(model.rest.size());
  }
  return nearest;
}

// Each node belongs to its nearest body; diffused over the surface, (1 + l^2 Laplacian)^2 share =
// that, so that the change from body to body spans about the limb's radius l on either side.
void share_out(const Nearest& nearest, int bodies, SkinModel& model) {
  const int nodes = static_cast<int>(model.rest.size());
  const double spread = nearest.mean_distance / mean_edge(model);
  const Skyline matrix = laplacian(model, 0.5 * spread * spread, std::vector<double>(nodes, 1.0));
  SkylineFactor factor;
  factorise(matrix, std::vector<double>(nodes, 0.0), factor);
  std::vector<std::vector<double>> share(nodes, std::vector<double>(bodies, 0.0));
  constexpr int kLanes = 8;
  for (int first = 0; first < bodies; first += kLanes) {
    RowPairs rows(nodes, RowPair{});
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
  for (int i = 0; i < nodes; ++i) {  // the four largest, the rest dropped
    std::vector<int> order(bodies);
    for (int b = 0; b < bodies; ++b) order[b] = b;
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return share[i][a] > share[i][b]; });
    std::array<int, 4> body{-1, -1, -1, -1};
    std::array<double, 4> part{0, 0, 0, 0};
    double sum = 0.0;
    for (int k = 0; k < std::min(4, bodies); ++k) {
      body[k] = order[k];
      part[k] = share[i][order[k]];
      sum += part[k];
    }
    for (double& p : part) p /= sum;
    model.bodies.push_back(body);
    model.shares.push_back(part);
  }
}

void measure_fat(const std::vector<Collider>& below, SkinModel& model) {
  const int nodes = static_cast<int>(model.rest.size());
  FleshPlanes planes;
  planes.planes.resize(nodes);
  planes.count.resize(nodes);
  std::vector<int> hints(nodes * below.size(), -1);
  const double bridging = model.settings.bridging;
  for (int i = 0; i < nodes; ++i) {
    const Vec3 x = to_vec(model.rest[i]);
    find_flesh(below, x, kFatReach, bridging, i, hints, planes);
    const FleshValue flesh = flesh_value(planes, i, x, bridging);
    const bool any = flesh.nearest_plane >= 0;
    model.fat.push_back(any ? flesh.level : kFatReach);
    // A rest shape that lies nearer than the thickness may stay so, but never inside.
    const double room = any ? std::max(flesh.nearest, 0.0) : model.settings.thickness;
    model.least.push_back(std::min(model.settings.thickness, room));
  }
}

}  // namespace

SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings) {
  SkinModel model;
  model.surface = make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size()));
  for (const Vec3& p : mesh.vertices) model.rest.push_back(to_row(p));
  model.bind_pose = bind_pose;
  model.settings = settings;
  model.edges = edges_of(model.surface);
  model.edge_weights = cotangent_weights(model);
  std::vector<std::vector<std::pair<int, double>>> across(model.rest.size());
  for (size_t e = 0; e < model.edges.size(); ++e) {
    const auto& [a, b] = model.edges[e];
    across[a].push_back({b, model.edge_weights[e]});
    across[b].push_back({a, model.edge_weights[e]});
  }
  model.first_neighbour.push_back(0);
  for (const auto& nodes : across) {
    for (const auto& [node, weight] : nodes) {
      model.neighbours.push_back(node);
      model.weights.push_back(edge_stiffness(settings) * weight);
    }
    model.first_neighbour.push_back(static_cast<int>(model.neighbours.size()));
  }
  share_out(nearest_bodies(model, below, bodies_of), skeleton.size(), model);
  measure_fat(below, model);
  // Skin is held to its body where it belongs to that body alone, and slides over the joints.
  const double hold = mean_edge(model) / kAnchorLength;
  std::vector<double> diagonal;
  for (const auto& share : model.shares) {
    const double pure = std::max(2.0 * share[0] - 1.0, 0.0);
    model.anchor.push_back(hold * hold * pure * pure);
    diagonal.push_back(model.anchor.back());
  }
  model.matrix = laplacian(model, edge_stiffness(settings), diagonal);
  factorise(model.matrix, std::vector<double>(diagonal.size(), 0.0), model.factor);
  return model;
}

}  // namespace thew
