// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

namespace thew::muscles {

/// Hill-type curves of a fibre, normalised (Thelen 2003, eqs 3, 4, 6 and 7). Lengths are in optimal
/// fibre lengths, velocities in optimal fibre lengths per second (negative as the fibre shortens),
/// results in maximal isometric forces. The default of `max_velocity` is that of young adults
/// (table 1).
double active_force_length(double length);
double passive_force_length(double length);
double force_velocity(double velocity, double max_velocity = 10.0);

/// Tension (N) of a muscle: f_max (activation fl(length) fv(velocity) + passive(length)); f_max in
/// N, activation in 0..1.
double muscle_tension(double f_max, double activation, double length, double velocity);

/// Activation by the angle (degrees) of the joint that a muscle moves, of a kind of muscle:
/// "flexor" or "extensor". Throws std::invalid_argument for another.
std::vector<std::array<double, 2>> activation_preset(const std::string& kind);

}  // namespace thew::muscles
