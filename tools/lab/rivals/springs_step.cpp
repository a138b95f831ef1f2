// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/springs_step.h"

#include <memory>

#include "muscles/volume.h"

namespace thew::tools {
namespace {

constexpr int kRounds = 8;  // of correction and obstacles, by turns

// Takes the part towards an obstacle out of the directions of nodes that would enter it. Whether
// there was one.
bool stop_at_obstacles(const Surroundings& around, double time, double s, const RivalBody& body,
                       Points& direction) {
  bool stopped = false;
  for (size_t i = 0; around.beyond && i < body.x.size(); ++i) {
    if (body.driven[i]) continue;
    const Vec3 depth = around.beyond(time, to_vec(body.x[i] + s * direction[i]));
    if (depth.norm() < 1e-12) continue;
    const Point n = to_point(depth.normalized());
    const double part = dot(direction[i], n);
    if (part * s <= 0.0) continue;
    direction[i] -= part * n;
    stopped = true;
  }
  return stopped;
}

}  // namespace

SurfaceSprings prepare_springs(const RivalBody& body, double drag, bool opposite) {
  SurfaceSprings out;
  out.drag = drag;
  if (!opposite) out.material.shear = out.material.bending = 0.0;
  const Springs springs = make_springs({body.rest, body.triangles}, {}, out.material);
  out.rings = make_ring_springs(body.triangles, std::vector<char>(body.rest.size(), 0), springs);
  lengths_by_slot(out.rings, springs.rest_length, out.rest_length);
  return out;
}

void spring_forces(const SurfaceSprings& springs, const RivalBody& body, Points& f,
                   Points* gradient) {
  f.resize(body.x.size());
  if (gradient) gradient->resize(body.x.size());
  ring_forces(springs.rings, springs.rest_length, springs.rings.all(), body.x, body.v,
              springs.dashpot, f, gradient);
}

void free_step(const Surroundings& around, double time, double h, double drag, const Points& f,
               RivalBody& body) {
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (body.driven[i]) continue;
    body.v[i] += h * (1.0 / body.mass[i] * f[i] - drag * body.v[i]);
    body.x[i] += h * body.v[i];
  }
  drive_nodes(around, time, h, body);
  keep_out(around, time, body);
}

double volume_correction(const Surroundings& around, double time, double rest, bool by_mass,
                         const RivalBody& body, Points& direction) {
  volume_gradient(body.x, body.triangles, direction);
  for (size_t i = 0; i < direction.size(); ++i) {
    direction[i] *= body.driven[i] ? 0.0 : by_mass ? 1.0 / body.mass[i] : 1.0;
  }
  double s = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    s = nearest_root(volume_along(body.x, direction, body.triangles), rest).s;
    if (!stop_at_obstacles(around, time, s, body, direction)) break;
  }
  return s;
}

Stepper corrected_stepper(const RivalBody& body, double drag, bool by_mass, bool reaction) {
  const auto springs = std::make_shared<const SurfaceSprings>(prepare_springs(body, drag));
  return [=, rest = volume_of(body), f = Points(), direction = Points()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    spring_forces(*springs, now, f, nullptr);
    free_step(around, time, h, springs->drag, f, now);
    const double s = volume_correction(around, time, rest, by_mass, now, direction);
    for (size_t i = 0; i < now.x.size(); ++i) {
      now.x[i] += s * direction[i];
      if (reaction) now.v[i] += s / h * direction[i];
    }
  };
}

}  // namespace thew::tools
