// SPDX-License-Identifier: Apache-2.0
#include "tools/author/outline.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace thew::tools {
namespace {

// A section of the limb's outline: an ellipse across y. Girths and widths after BodyParts3D, of the
// upper arm moved by up to 4 mm for muscles that fill it less well; below the elbow turned with the
// forearm, which hangs half turned.
struct Outline {
  double y, x, z, half_x, half_z;  // m
};
constexpr std::array<Outline, 27> kLimb = {
    {{0.075, 0.000, -0.010, 0.0040, 0.0040},  {0.050, -0.003, -0.012, 0.0150, 0.0140},
     {0.043, -0.003, -0.010, 0.0280, 0.0270}, {0.027, -0.002, -0.005, 0.0410, 0.0400},
     {0.005, -0.001, -0.001, 0.0485, 0.0465}, {-0.025, 0.000, 0.002, 0.0525, 0.0495},
     {-0.052, 0.001, 0.001, 0.0517, 0.0490},  {-0.082, 0.001, -0.001, 0.0480, 0.0430},
     {-0.116, 0.001, -0.003, 0.0475, 0.0405}, {-0.145, 0.001, -0.003, 0.0475, 0.0400},
     {-0.174, 0.003, -0.003, 0.0460, 0.0390}, {-0.203, 0.006, -0.003, 0.0465, 0.0420},
     {-0.232, 0.006, -0.003, 0.0405, 0.0400}, {-0.261, 0.004, -0.003, 0.0355, 0.0375},
     {-0.276, 0.004, -0.003, 0.0350, 0.0380}, {-0.303, 0.004, -0.001, 0.0370, 0.0415},
     {-0.328, 0.004, 0.001, 0.0395, 0.0450},  {-0.354, 0.004, 0.005, 0.0410, 0.0460},
     {-0.379, 0.006, 0.008, 0.0415, 0.0440},  {-0.405, 0.008, 0.011, 0.0395, 0.0400},
     {-0.430, 0.010, 0.014, 0.0365, 0.0360},  {-0.455, 0.011, 0.017, 0.0330, 0.0315},
     {-0.481, 0.014, 0.021, 0.0300, 0.0265},  {-0.515, 0.018, 0.026, 0.0296, 0.0223},
     {-0.545, 0.022, 0.030, 0.0278, 0.0190},  {-0.575, 0.026, 0.034, 0.0320, 0.0180},
     {-0.600, 0.027, 0.035, 0.0330, 0.0160}}};

// Cubic through four values at four heights (Hermite, slopes by differences), between the middle
// two.
double between(const std::array<double, 4>& y, const std::array<double, 4>& value, double at) {
  const double step = y[2] - y[1], t = (at - y[1]) / step;
  const double m1 = step * (value[2] - value[0]) / (y[2] - y[0]);
  const double m2 = step * (value[3] - value[1]) / (y[3] - y[1]);
  return value[1] + t * (m1 + t * (3 * (value[2] - value[1]) - 2 * m1 - m2 +
                                   t * (2 * (value[1] - value[2]) + m1 + m2)));
}

}  // namespace

double limb_level(const Vec3& p) {
  const double y = std::clamp(p.y(), kLimb[kLimb.size() - 2].y, kLimb[1].y);
  size_t i = 1;
  while (i + 3 < kLimb.size() && kLimb[i + 1].y > y) ++i;
  const auto at = [&](double Outline::*value) {
    std::array<double, 4> heights, values;
    for (size_t k = 0; k < 4; ++k) {
      heights[k] = kLimb[i - 1 + k].y;
      values[k] = kLimb[i - 1 + k].*value;
    }
    return between(heights, values, y);
  };
  const double a = at(&Outline::half_x), b = at(&Outline::half_z);
  const double u = (p.x() - at(&Outline::x)) / a, v = (p.z() - at(&Outline::z)) / b;
  const double across = std::min(a, b) * (std::sqrt(u * u + v * v) - 1.0);
  return p.y() == y ? across : std::max(across, std::abs(p.y() - y));
}

}  // namespace thew::tools
