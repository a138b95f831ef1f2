// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/nedel.h"

#include <map>
#include <memory>

namespace thew::tools {
namespace {

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

std::vector<AngularSpring> angular_springs(const RivalBody& body) {
  std::vector<std::map<int, int>> next(body.rest.size());  // by node: around its ring
  for (const Triangle& t : body.triangles) {
    for (int k = 0; k < 3; ++k) next[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
  }
  std::vector<AngularSpring> springs;
  for (int i = 0; i < static_cast<int>(next.size()); ++i) {
    if (next[i].empty()) continue;
    std::vector<int> ring = {next[i].begin()->first};
    while (ring.size() < next[i].size()) ring.push_back(next[i].at(ring.back()));
    const size_t half = ring.size() / 2;
    for (size_t k = 0; k < (ring.size() + 1) / 2; ++k) {
      const int a = ring[k], b = ring[(k + half) % ring.size()];
      springs.push_back(
          {i, a, b, angle_between(body.rest[a] - body.rest[i], body.rest[b] - body.rest[i])});
    }
  }
  return springs;
}

void add_angular_forces(const std::vector<AngularSpring>& springs, double stiffness,
                        const Points& x, Points& f) {
  for (const AngularSpring& spring : springs) {
    const Vec3 a = to_vec(x[spring.a] - x[spring.at]), b = to_vec(x[spring.b] - x[spring.at]);
    Vec3 axis = a.cross(b);
    const double sine = axis.norm();
    if (!(sine > 1e-9 * a.norm() * b.norm())) continue;  // straight: no direction to turn in
    axis /= sine;
    const double torque = stiffness * (std::atan2(sine, a.dot(b)) - spring.rest);
    // The angle grows as a turns against the axis and b with it.
    const Point fa = to_point(torque / a.squaredNorm() * axis.cross(a));
    const Point fb = to_point(-torque / b.squaredNorm() * axis.cross(b));
    f[spring.a] += fa;
    f[spring.b] += fb;
    f[spring.at] -= fa + fb;
  }
}

Stepper nedel_stepper(const RivalBody& body, double drag, double stiffness) {
  const auto springs = std::make_shared<const SurfaceSprings>(prepare_springs(body, drag, false));
  return [springs, stiffness, angles = angular_springs(body), f = Points()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    spring_forces(*springs, now, f, nullptr);
    add_angular_forces(angles, stiffness, now.x, f);
    free_step(around, time, h, springs->drag, f, now);
  };
}

}  // namespace thew::tools
