// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::muscles {

/// Hill-type curves of a fibre, normalised (Thelen 2003, eqs 1-7): length in optimal fibre lengths,
/// velocity in optimal fibre lengths per second (negative: shortening), force in maximal isometric
/// force.
double active_force_length(double length);
double passive_force_length(double length);
double force_velocity(double velocity, double max_velocity = 10.0);

/// Tension (N) of a muscle: f_max * (activation * fl * fv + passive).
double muscle_tension(double f_max, double activation, double length, double velocity);

}  // namespace thew::muscles
