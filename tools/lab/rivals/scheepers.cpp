// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/scheepers.h"

namespace thew::tools {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Extent {
  Vec3 half, middle;
};
Extent extent_of(const Points& x) {
  Vec3 low = to_vec(x[0]), high = low;
  for (const Point& p : x) {
    low = low.cwiseMin(to_vec(p));
    high = high.cwiseMax(to_vec(p));
  }
  return {0.5 * (high - low), 0.5 * (low + high)};
}

}  // namespace

Vec3 scheepers_axes(double volume, double ratio, double c) {
  const double b = std::sqrt(3.0 * volume / (4.0 * kPi * ratio * c));
  return {ratio * b, b, c};
}

Stepper scheepers_stepper(const RivalBody& body) {
  const Extent rest = extent_of(body.x);
  return [rest](const Surroundings& around, double time, double h, RivalBody& now) {
    const Points before = now.x;
    drive_nodes(around, time, h, now);
    Points ends;
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (now.driven[i]) ends.push_back(now.x[i]);
    }
    const Extent at = extent_of(ends.empty() ? now.x : ends);
    const double volume = 4.0 / 3.0 * kPi * rest.half.prod();
    const Vec3 axes = scheepers_axes(volume, rest.half.z() / rest.half.y(), at.half.x());
    const Vec3 scale(axes.z() / rest.half.x(), axes.y() / rest.half.y(), axes.x() / rest.half.z());
    for (size_t i = 0; i < now.x.size(); ++i) {
      now.x[i] = to_point(at.middle + scale.cwiseProduct(now.rest[i] - rest.middle));
      now.v[i] = 1.0 / h * (now.x[i] - before[i]);
    }
  };
}

}  // namespace thew::tools
