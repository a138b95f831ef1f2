// SPDX-License-Identifier: Apache-2.0
#include "muscles/weights.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace thew::muscles {

WeightProfile preset_profile(const std::string& name) {
  if (name == "left") return {{{0.3, 1.8}, {0.7, 0.2}}};
  if (name == "even") return {};
  if (name == "right") return {{{0.3, 0.2}, {0.7, 1.8}}};
  throw std::invalid_argument("weights \"" + name + "\" are not known; use left, even or right");
}

double profile_weight(const WeightProfile& profile, double u) {
  return keyed_value(profile.keys, u);
}

double keyed_value(const std::vector<std::array<double, 2>>& keys, double u) {
  if (u <= keys.front()[0]) return keys.front()[1];
  for (size_t i = 1; i < keys.size(); ++i) {
    if (u > keys[i][0]) continue;
    const double t = (u - keys[i - 1][0]) / (keys[i][0] - keys[i - 1][0]);
    return keys[i - 1][1] + t * (keys[i][1] - keys[i - 1][1]);
  }
  return keys.back()[1];
}

std::vector<double> profile_weights(const WeightProfile& profile, const std::vector<double>& u) {
  std::vector<double> weights;
  for (const double at : u) weights.push_back(profile_weight(profile, at));
  return weights;
}

std::vector<double> normalised_weights(std::vector<double> weights,
                                       const std::vector<char>& driven) {
  double sum = 0.0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] >= 0.0) || !std::isfinite(weights[i])) {
      throw std::invalid_argument("weight of node " + std::to_string(i) +
                                  " is negative or not finite; weights are zero or more");
    }
    if (driven[i]) weights[i] = 0.0;
    sum += weights[i];
  }
  if (!(sum > 0.0)) {
    throw std::invalid_argument(
        "weights are zero on all nodes that are free to move; give some of them a weight");
  }
  const double scale = static_cast<double>(weights.size()) / sum;
  for (double& w : weights) w *= scale;
  return weights;
}

double limit_concentration(std::vector<double>& weights,
                           const std::vector<double>& gradient_squared_over_mass,
                           const std::vector<char>& driven, double ratio) {
  if (!(ratio > 1.0)) {
    throw std::invalid_argument("limit of the weights' concentration is not above 1; raise it");
  }
  // The share of a node is W_i g_i / sum W g, and g_i / sum g under even weights. So the limit
  // reads W_i <= ratio mean, where the mean of W is weighted by g. A floor f adds f to both W_i and
  // mean.
  const std::vector<double>& g = gradient_squared_over_mass;
  double weighted = 0.0, even = 0.0, largest = 0.0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (driven[i] || !(g[i] > 0.0)) continue;  // such a node does not move, whatever its weight
    weighted += weights[i] * g[i];
    even += g[i];
    largest = std::max(largest, weights[i]);
  }
  if (!(even > 0.0)) return 0.0;
  const double floor = (largest - ratio * (weighted / even)) / (ratio - 1.0);
  // Of the largest weight: a floor that was added before leaves this much.
  constexpr double kRounding = 1e-12;
  if (!(floor > kRounding * largest)) return 0.0;
  for (double& w : weights) w += floor;
  weights = normalised_weights(std::move(weights), driven);
  return floor;
}

void remove_net_motion(const Points& x, const std::vector<double>& mass, Points& d) {
  Vec3 moment = Vec3::Zero(), momentum = Vec3::Zero();
  double total = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    total += mass[i];
    moment += mass[i] * to_vec(x[i]);
    momentum += mass[i] * to_vec(d[i]);
  }
  const Vec3 centre = moment / total, shift = momentum / total;
  Vec3 spin = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 r = to_vec(x[i]) - centre;
    spin += mass[i] * r.cross(to_vec(d[i]) - shift);
    inertia += mass[i] * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  // Nodes on one line (or at one point) cannot rotate about it; keep the matrix regular there.
  const double size = inertia.trace() / 3.0;
  if (!(inertia.determinant() > 1e-12 * size * size * size)) {
    inertia += (size > 0.0 ? 1e-9 * size : 1.0) * Mat3::Identity();
  }
  const Vec3 rate = inertia.inverse() * spin;
  for (size_t i = 0; i < x.size(); ++i) {
    d[i] -= to_point(shift + rate.cross(to_vec(x[i]) - centre));
  }
}

}  // namespace thew::muscles
