// SPDX-License-Identifier: Apache-2.0
#include "muscles/zone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "muscles/weights.h"
#include "rig/math.h"

namespace thew {
namespace {

struct Link {
  int to;
  double length;  // m
};

// Distance between p and q, the vertices opposite the edge a-b, in the plane that both triangles
// unfold into; infinity where the straight line leaves the two triangles.
double unfolded_distance(const Vec3& a, const Vec3& b, const Vec3& p, const Vec3& q) {
  const Vec3 edge = b - a;
  const double length = edge.norm();
  const double px = (p - a).dot(edge) / length, qx = (q - a).dot(edge) / length;
  const double py = (p - a).cross(edge).norm() / length, qy = (q - a).cross(edge).norm() / length;
  const double crossing = px + (qx - px) * py / (py + qy);
  if (!(crossing >= 0.0 && crossing <= length)) return std::numeric_limits<double>::infinity();
  return std::sqrt((qx - px) * (qx - px) + (py + qy) * (py + qy));
}

std::vector<std::vector<Link>> surface_links(const TriMesh& mesh) {
  std::vector<std::array<int, 3>> sides;  // edge, smaller index first, and the vertex opposite
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({a, b, t[(k + 2) % 3]});
    }
  }
  std::sort(sides.begin(), sides.end());
  const std::vector<Vec3>& x = mesh.vertices;
  std::vector<std::vector<Link>> links(x.size());
  const auto link = [&](int i, int j, double length) {
    links[i].push_back({j, length});
    links[j].push_back({i, length});
  };
  for (size_t i = 0; i < sides.size(); ++i) {
    const auto [a, b, p] = sides[i];
    const bool seen = i > 0 && sides[i - 1][0] == a && sides[i - 1][1] == b;
    if (!seen) {
      link(a, b, (x[b] - x[a]).norm());
    } else {
      const int q = sides[i - 1][2];
      link(p, q, unfolded_distance(x[a], x[b], x[p], x[q]));
    }
  }
  return links;
}

}  // namespace

std::vector<double> surface_distance(const TriMesh& mesh, const std::vector<int>& sources) {
  const std::vector<std::vector<Link>> links = surface_links(mesh);
  std::vector<double> distance(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;  // Dijkstra, ties by index
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  for (int source : sources) {
    distance[source] = 0.0;
    front.push({0.0, source});
  }
  while (!front.empty()) {
    const auto [at, node] = front.top();
    front.pop();
    if (at > distance[node]) continue;
    for (const auto& [to, length] : links[node]) {
      if (!(at + length < distance[to])) continue;
      distance[to] = at + length;
      front.push({distance[to], to});
    }
  }
  return distance;
}

double grown_radius(const ZoneSettings& settings, double radius, double load, double dt) {
  return std::clamp(radius + settings.per_impulse * load * dt, settings.smallest_radius,
                    settings.largest_radius);
}

double zone_weight(double distance, double radius) {
  if (distance == 0.0) return 1.0;  // a zone of no radius is the loaded nodes themselves
  if (!(distance < radius)) return 0.0;
  return 0.5 * (sin_cos(kPi * distance / radius).cos + 1.0);
}

std::vector<double> zone_weights(const TriMesh& mesh, const std::vector<int>& loaded_nodes,
                                 const Vec3& load_direction, const ZoneSettings& settings,
                                 double radius) {
  // Distances along the load count for less: measure them on the mesh flattened along it.
  TriMesh flattened = mesh;
  for (Vec3& p : flattened.vertices) {
    p -= settings.along_load * p.dot(load_direction) * load_direction;
  }
  std::vector<double> weights = surface_distance(flattened, loaded_nodes);
  for (double& w : weights) w = zone_weight(w, radius);
  const std::vector<char> none_driven(weights.size(), 0);
  return normalised_weights(std::move(weights), none_driven);
}

}  // namespace thew
