// SPDX-License-Identifier: Apache-2.0
#include "muscles/zone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "rig/math.h"

namespace thew::muscles {
namespace {

// Distance between p and q, the vertices opposite the edge a-b, in the plane into which both
// triangles unfold; infinity if the straight line leaves the two triangles.
double unfolded_distance(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q) {
  const Vec3 edge = b - a;
  const double length = edge.norm();
  const double px = (p - a).dot(edge) / length, qx = (q - a).dot(edge) / length;
  const double py = (p - a).cross(edge).norm() / length, qy = (q - a).cross(edge).norm() / length;
  const double crossing = px + (qx - px) * py / (py + qy);
  if (!(crossing >= 0.0 && crossing <= length)) return std::numeric_limits<double>::infinity();
  return std::sqrt((qx - px) * (qx - px) + (py + qy) * (py + qy));
}

}  // namespace

SurfaceLinks surface_links(const TriMesh& mesh) {
  // Edge with the smaller index first, and the opposite vertex.
  std::vector<std::array<int, 3>> sides;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({a, b, t[(k + 2) % 3]});
    }
  }
  std::sort(sides.begin(), sides.end());
  SurfaceLinks out;
  for (size_t i = 0; i < sides.size(); ++i) {
    const auto [a, b, p] = sides[i];
    const bool seen = i > 0 && sides[i - 1][0] == a && sides[i - 1][1] == b;
    if (seen) {
      out.pairs.push_back({{p, sides[i - 1][2]}, {a, b}});
    } else {
      out.pairs.push_back({{a, b}, {-1, -1}});
    }
  }
  const size_t nodes = mesh.vertices.size();
  std::vector<std::vector<SurfaceLinks::Link>> of_node(nodes);
  for (int k = 0; k < static_cast<int>(out.pairs.size()); ++k) {
    const auto [i, j] = out.pairs[k].ends;
    of_node[i].push_back({j, k});
    of_node[j].push_back({i, k});
  }
  out.first.push_back(0);
  for (const auto& links : of_node) {
    out.links.insert(out.links.end(), links.begin(), links.end());
    out.first.push_back(static_cast<int>(out.links.size()));
  }
  return out;
}

void surface_distance(const SurfaceLinks& links, const std::vector<Vec3>& x,
                      const std::vector<int>& sources, ZoneWork& work,
                      std::vector<double>& distance) {
  work.lengths.clear();
  for (const auto& [ends, edge] : links.pairs) {
    const Vec3 &p = x[ends[0]], &q = x[ends[1]];
    work.lengths.push_back(edge[0] < 0 ? (q - p).norm()
                                       : unfolded_distance(x[edge[0]], x[edge[1]], p, q));
  }
  distance.assign(x.size(), std::numeric_limits<double>::infinity());
  // Of Dijkstra's algorithm, ties by index.
  std::vector<std::pair<double, int>>& front = work.front;
  const auto reach = [&](int node, double at) {
    distance[node] = at;
    front.emplace_back(at, node);
    std::push_heap(front.begin(), front.end(), std::greater<>());
  };
  front.clear();
  for (const int source : sources) reach(source, 0.0);
  while (!front.empty()) {
    const auto [at, node] = front.front();
    std::pop_heap(front.begin(), front.end(), std::greater<>());
    front.pop_back();
    if (at > distance[node]) continue;
    for (int k = links.first[node]; k < links.first[node + 1]; ++k) {
      const auto& [to, pair] = links.links[k];
      if (at + work.lengths[pair] < distance[to]) reach(to, at + work.lengths[pair]);
    }
  }
}

double grown_radius(const ZoneSettings& settings, double radius, double load, double dt) {
  return std::clamp(radius + settings.per_impulse * load * dt, settings.smallest_radius,
                    settings.largest_radius);
}

double zone_weight(double distance, double radius) {
  if (distance == 0.0) return 1.0;  // a zone of radius 0 has the loaded nodes alone
  if (!(distance < radius)) return 0.0;
  return 0.5 * (sin_cos(kPi * distance / radius).cos + 1.0);
}

void zone_weights(const SurfaceLinks& links, const std::vector<Vec3>& rest,
                  const Vec3& load_direction, const ZoneSettings& settings, double radius,
                  ZoneWork& work, std::vector<double>& weights) {
  // Distances along the load count less, so they are measured on a mesh that is flattened along it.
  work.x = rest;
  for (Vec3& p : work.x) p -= settings.along_load * p.dot(load_direction) * load_direction;
  surface_distance(links, work.x, work.loaded, work, weights);
  double sum = 0.0;
  for (double& w : weights) sum += w = zone_weight(w, radius);
  const double scale = static_cast<double>(weights.size()) / sum;
  for (double& w : weights) w *= scale;
}

}  // namespace thew::muscles
