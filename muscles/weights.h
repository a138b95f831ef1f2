// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Weight against the axis coordinate u in 0..1 from origin to insertion of the belly; linear
/// between keys, constant beyond them. The paper's figure 3: left 1.8 up to u = 0.3, 0.2 from 0.7,
/// even 1, right.
struct WeightProfile {
  std::vector<std::array<double, 2>> keys = {{{0.0, 1.0}}, {{1.0, 1.0}}};
};
/// "left", "even" or "right"; throws std::invalid_argument otherwise.
WeightProfile preset_profile(const std::string& name);
double profile_weight(const WeightProfile& profile, double u);
/// The same of any curve by its keys, of which there is one at least.
double keyed_value(const std::vector<std::array<double, 2>>& keys, double at);
/// By node, of nodes at these coordinates.
std::vector<double> profile_weights(const WeightProfile& profile, const std::vector<double>& u);

/// Weights set to 0 where `driven`, and scaled so that their sum is n, the paper's convention.
/// Throws std::invalid_argument for negative or non-finite weights, or if all are zero where
/// `driven` is zero.
std::vector<double> normalised_weights(std::vector<double> weights,
                                       const std::vector<char>& driven);

/// Limit relative to even weights: the smallest uniform floor, added to all weights before they are
/// normalised again, at which no free node's share of the volume correction exceeds `ratio` times
/// its share under even weights; `gradient_squared_over_mass[i]` = |dV/dx_i|^2 / m_i. Returns the
/// floor: 0 if the weights are tame already, as those are that it was added to.
double limit_concentration(std::vector<double>& weights,
                           const std::vector<double>& gradient_squared_over_mass,
                           const std::vector<char>& driven, double ratio = 1.5);

/// Takes net force and torque out of a displacement field so that a body that no bone holds keeps
/// its linear and angular momentum: d_i -= a + b x (x_i - c), with a, b from sum m d = 0,
/// sum m (x - c) x d = 0.
void remove_net_motion(const Points& x, const std::vector<double>& mass, Points& d);

}  // namespace thew::muscles
