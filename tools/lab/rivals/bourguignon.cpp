// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/bourguignon.h"

#include <map>
#include <memory>

namespace thew::tools {
namespace {

constexpr double kDashpot = 1e-4;  // s

void add_edge_forces(const Springs& springs, const RivalBody& body, Points& f) {
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const Point d = body.x[b] - body.x[a];
    const double length = std::sqrt(dot(d, d));
    const double rate = dot(body.v[b] - body.v[a], d) / length;
    const Point force =
        springs.stiffness[k] / length * (length - springs.rest_length[k] + kDashpot * rate) * d;
    f[a] += force;
    f[b] -= force;
  }
}

}  // namespace

BarycentreSprings barycentre_springs(const RivalBody& body, double stiffness) {
  BarycentreSprings out{stiffness, {}};
  for (const Tetrahedron& t : body.tetrahedra) {
    Vec3 centre = Vec3::Zero();
    for (const int node : t) centre += 0.25 * body.rest[node];
    double sum = 0.0;
    for (const int node : t) sum += (body.rest[node] - centre).norm();
    out.rest_sum.push_back(sum);
  }
  return out;
}

void add_barycentre_forces(const BarycentreSprings& springs, const RivalBody& body, Points& f) {
  for (size_t e = 0; e < body.tetrahedra.size(); ++e) {
    const Tetrahedron& t = body.tetrahedra[e];
    const Point centre = 0.25 * (body.x[t[0]] + body.x[t[1]] + body.x[t[2]] + body.x[t[3]]);
    Point way[4], left = {};
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
      way[k] = body.x[t[k]] - centre;
      const double length = std::sqrt(dot(way[k], way[k]));
      sum += length;
      way[k] *= 1.0 / length;
      left += 0.25 * way[k];
    }
    const double pull = springs.stiffness * (sum - springs.rest_sum[e]);
    for (int k = 0; k < 4; ++k) f[t[k]] -= pull * (springs.balanced ? way[k] - left : way[k]);
  }
}

Springs solid_springs(const RivalBody& body, double young) {
  std::map<std::array<int, 2>, double> volumes;
  const TetMesh rest{body.rest, {}};
  for (const Tetrahedron& t : body.tetrahedra) {
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        const auto [low, high] = std::minmax(t[a], t[b]);
        volumes[{low, high}] += signed_volume(rest, t);
      }
    }
  }
  Springs out;
  for (const auto& [ends, volume] : volumes) {
    const double length = (body.rest[ends[1]] - body.rest[ends[0]]).norm();
    out.nodes.push_back(ends);
    out.rest_length.push_back(length);
    out.stiffness.push_back(young * volume / (length * length));
  }
  return out;
}

Stepper bourguignon_stepper(const RivalBody& body, double drag, double young, double stiffness) {
  const auto springs = std::make_shared<const Springs>(solid_springs(body, young));
  return [springs, drag, soft = barycentre_springs(body, stiffness), f = Points()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    f.assign(now.x.size(), Point{});
    add_edge_forces(*springs, now, f);
    if (soft.stiffness > 0.0) add_barycentre_forces(soft, now, f);
    free_step(around, time, h, drag, f, now);
  };
}

}  // namespace thew::tools
