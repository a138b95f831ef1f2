// SPDX-License-Identifier: Apache-2.0
#include "muscles/activation.h"

#include <cmath>
#include <stdexcept>

namespace thew::muscles {
namespace {

// Thelen 2003, table 1, young adults.
constexpr double kActiveShape = 0.45;        // gamma
constexpr double kPassiveShape = 5.0;        // k^PE
constexpr double kPassiveStrain = 0.6;       // eps_0^M, strain at which passive force is f_max
constexpr double kVelocityShape = 0.25;      // A_f
constexpr double kLargestLengthening = 1.4;  // F_len^M

// e^x with the same bytes on every processor: x = k ln 2 + r, then Taylor for |r| <= 0.35, whose
// next term is below 1e-17.
double exponential(double x) {
  if (!(std::fabs(x) < 700.0)) return x < 0.0 ? 0.0 : x * HUGE_VAL;  // NaN stays NaN
  const double k = std::floor(x * 1.4426950408889634 + 0.5);
  const double r = (x - k * 0x1.62e42fee00000p-1) - k * 0x1.a39ef35793c76p-33;
  double sum = 1.0;
  for (int n = 14; n >= 1; --n) sum = 1.0 + sum * r / n;
  return std::ldexp(sum, static_cast<int>(k));
}

}  // namespace

double active_force_length(double length) {
  const double x = length - 1.0;
  return exponential(-x * x / kActiveShape);  // eq. 4
}

double passive_force_length(double length) {
  if (length <= 1.0) return 0.0;
  return (exponential(kPassiveShape * (length - 1.0) / kPassiveStrain) - 1.0) /
         (exponential(kPassiveShape) - 1.0);  // eq. 3
}

double force_velocity(double velocity, double max_velocity) {
  // Eqs 6 and 7, solved for the force, at full activation.
  if (velocity <= -max_velocity) return 0.0;
  if (velocity <= 0.0)
    return (max_velocity + velocity) / (max_velocity - velocity / kVelocityShape);
  const double c = (2.0 + 2.0 / kVelocityShape) / (kLargestLengthening - 1.0);
  return (max_velocity + kLargestLengthening * c * velocity) / (max_velocity + c * velocity);
}

double muscle_tension(double f_max, double activation, double length, double velocity) {
  return f_max * (activation * active_force_length(length) * force_velocity(velocity) +
                  passive_force_length(length));
}

std::vector<std::array<double, 2>> activation_preset(const std::string& kind) {
  // The weight of a limb that hangs from its hinge has the moment m g l sin q about it, which the
  // flexor holds. An extensor only goes along to steady the joint, with a fifth of that. The
  // amplitudes and the tone at rest are chosen, not measured.
  constexpr double kTone = 0.05, kFlexor = 0.45, kExtensor = 0.09;
  if (kind != "flexor" && kind != "extensor") {
    throw std::invalid_argument("activation \"" + kind + "\" is not known; use flexor or extensor");
  }
  constexpr std::array<double, 2> kSines[] = {{0.0, 0.0},  {30.0, 0.5},        {60.0, 0.8660254},
                                              {90.0, 1.0}, {120.0, 0.8660254}, {150.0, 0.5},
                                              {180.0, 0.0}};
  std::vector<std::array<double, 2>> curve;
  for (const auto& [angle, sine] : kSines) {
    curve.push_back({angle, kTone + (kind == "flexor" ? kFlexor : kExtensor) * sine});
  }
  return curve;
}

}  // namespace thew::muscles
