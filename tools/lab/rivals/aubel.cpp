// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/aubel.h"

#include <limits>

namespace thew::tools {
namespace {

// Where the belly begins and ends along x, m: the innermost held nodes.
std::array<double, 2> belly_at(const RivalBody& body, const Points& x) {
  std::array<double, 2> ends = {-std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::infinity()};
  for (size_t i = 0; i < x.size(); ++i) {
    if (!body.driven[i]) continue;
    if (body.rest[i].x() < 0.0) ends[0] = std::max(ends[0], x[i][0]);
    if (body.rest[i].x() > 0.0) ends[1] = std::min(ends[1], x[i][0]);
  }
  return ends;
}

}  // namespace

double aubel_widening(double rest_length, double length) { return std::sqrt(rest_length / length); }

Stepper aubel_stepper(const RivalBody& body) {
  return [rest = belly_at(body, to_points(body.rest))](const Surroundings& around, double time,
                                                       double h, RivalBody& now) {
    const Points before = now.x;
    drive_nodes(around, time, h, now);
    const std::array<double, 2> at = belly_at(now, now.x);
    const double stretch = (at[1] - at[0]) / (rest[1] - rest[0]);
    const double wider = aubel_widening(rest[1] - rest[0], at[1] - at[0]);
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (now.driven[i]) continue;
      const Vec3& p = now.rest[i];
      now.x[i] = to_point({at[0] + stretch * (p.x() - rest[0]), wider * p.y(), wider * p.z()});
      now.v[i] = 1.0 / h * (now.x[i] - before[i]);
    }
  };
}

}  // namespace thew::tools
