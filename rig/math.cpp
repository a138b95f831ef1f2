// SPDX-License-Identifier: Apache-2.0
#include "rig/math.h"

#include <cmath>
#include <limits>

namespace thew::rig {
namespace {

// pi/2 in three parts (Cody and Waite 1980). The first two have 33 bits, so that their products
// with a quadrant number below 2^20 are exact.
constexpr double kHalfPiHigh = 0x1.921fb54400000p+0;
constexpr double kHalfPiMiddle = 0x1.0b4611a600000p-34;
constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;

// Taylor: sin(r + e) for |r| <= pi/4 and a tiny e; the next term is below 1e-19.
double sin_near_zero(double r, double e) {
  const double z = r * r;
  double p = 1.0 / 355687428096000.0;  // 1/17!
  p = p * z - 1.0 / 1307674368000.0;   // 1/15!
  p = p * z + 1.0 / 6227020800.0;
  p = p * z - 1.0 / 39916800.0;
  p = p * z + 1.0 / 362880.0;
  p = p * z - 1.0 / 5040.0;
  p = p * z + 1.0 / 120.0;
  p = p * z - 1.0 / 6.0;
  return r + (r * z * p + e * (1.0 - 0.5 * z));
}

// cos(r + e), likewise; 1 - z/2 is summed with the error of its own rounding.
double cos_near_zero(double r, double e) {
  const double z = r * r;
  double p = 1.0 / 20922789888000.0;  // 1/16!
  p = p * z - 1.0 / 87178291200.0;    // 1/14!
  p = p * z + 1.0 / 479001600.0;
  p = p * z - 1.0 / 3628800.0;
  p = p * z + 1.0 / 40320.0;
  p = p * z - 1.0 / 720.0;
  p = p * z + 1.0 / 24.0;
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * z * p - r * e));
}

// atan(k/8)
constexpr double kArcTan[9] = {0.0,
                               0.12435499454676144,
                               0.24497866312686414,
                               0.35877067027057225,
                               0.4636476090008061,
                               0.5585993153435624,
                               0.6435011087932844,
                               0.7188299996216245,
                               0.7853981633974483};

// atan(t) for 0 <= t <= 1: atan(c) + atan((t - c) / (1 + t c)) with c the nearest eighth; the
// series' argument is then at most 1/16 and its next term below 1e-19.
double arc_tan_unit(double t) {
  const int k = static_cast<int>(t * 8.0 + 0.5);
  const double c = k / 8.0;
  const double u = (t - c) / (1.0 + t * c);
  const double z = u * u;
  double p = 1.0 / 13.0;
  p = p * z - 1.0 / 11.0;
  p = p * z + 1.0 / 9.0;
  p = p * z - 1.0 / 7.0;
  p = p * z + 1.0 / 5.0;
  p = p * z - 1.0 / 3.0;
  return kArcTan[k] + (u + u * z * p);
}

}  // namespace

SinCos sin_cos(double angle) {
  if (!std::isfinite(angle)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  const double turns = std::floor(angle * kTwoOverPi + 0.5);
  const double high = angle - turns * kHalfPiHigh;  // exact
  const double middle = turns * kHalfPiMiddle;      // exact
  const double r = high - middle;
  const double e = ((high - r) - middle) - turns * kHalfPiLow;
  const double s = sin_near_zero(r, e), c = cos_near_zero(r, e);
  switch (static_cast<int>(turns - 4.0 * std::floor(turns / 4.0))) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double arc_tan2(double y, double x) {
  const double ax = std::fabs(x), ay = std::fabs(y);
  const double larger = ax > ay ? ax : ay;
  if (std::isnan(x) || std::isnan(y) || std::isinf(larger)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (larger == 0.0) return 0.0;
  double angle = ay <= ax ? arc_tan_unit(ay / ax) : kPi / 2.0 - arc_tan_unit(ax / ay);
  if (x < 0.0) angle = kPi - angle;
  return y < 0.0 ? -angle : angle;
}

Mat3 rotation_about(const Vec3& axis, double angle) {
  // R = cos I + sin [a]x + (1 - cos) a a^T
  const auto [s, c] = sin_cos(angle);
  Mat3 cross;
  cross << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  return c * Mat3::Identity() + s * cross + (1.0 - c) * (axis * axis.transpose());
}

Mat3 least_turn(const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const double sine = axis.norm();
  if (sine < 1e-12) return Mat3::Identity();
  return rotation_about(axis / sine, arc_tan2(sine, from.dot(to)));
}

double smoothstep(double a, double b, double t) {
  if (t <= a) return 0.0;
  if (t >= b) return 1.0;
  const double u = (t - a) / (b - a);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace thew::rig
