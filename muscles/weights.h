// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Weight against the coordinate u along the belly, 0 at the origin's end to 1 at the insertion's,
/// by keys (u, weight); linear between keys, constant beyond them.
struct WeightProfile {
  std::vector<std::array<double, 2>> keys = {{{0.0, 1.0}}, {{1.0, 1.0}}};
};
/// The profiles of the paper's figure 3: "left" is 1.8 up to u = 0.3 and 0.2 from u = 0.7 on,
/// "right" its mirror image, "even" is 1. Throws std::invalid_argument for another name.
WeightProfile preset_profile(const std::string& name);
double profile_weight(const WeightProfile& profile, double u);
/// The value at `at` of any curve by its keys (at, value), at least one.
double keyed_value(const std::vector<std::array<double, 2>>& keys, double at);
/// Weights of nodes at the coordinates u.
std::vector<double> profile_weights(const WeightProfile& profile, const std::vector<double>& u);

/// Weights set to 0 at driven nodes and scaled so that they sum to the number of nodes, as in the
/// paper. Throws std::invalid_argument if a weight is negative or not finite, or all free nodes
/// have weight 0.
std::vector<double> normalised_weights(std::vector<double> weights,
                                       const std::vector<char>& driven);

/// Adds the smallest constant (floor) to all weights and normalises them again, so that no free
/// node takes more than `ratio` times the share of the volume correction that it would take under
/// even weights. `gradient_squared_over_mass[i]` is |dV/dx_i|^2 / m_i. Returns the floor, 0 if the
/// weights are within the limit already. Throws std::invalid_argument unless ratio > 1.
double limit_concentration(std::vector<double>& weights,
                           const std::vector<double>& gradient_squared_over_mass,
                           const std::vector<char>& driven, double ratio = 1.5);

/// Removes the net translation and rotation from displacements d, so that a body without fixed
/// nodes keeps its linear and angular momentum: d_i -= a + b x (x_i - c), with c the centre of
/// mass, and a and b such that sum m d = 0 and sum m (x - c) x d = 0.
void remove_net_motion(const Points& x, const std::vector<double>& mass, Points& d);

}  // namespace thew::muscles
