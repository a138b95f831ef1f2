// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/basis.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace thew::tools {
namespace {

// A mode below this share of the largest eigenvalue is rounding error.
constexpr double kSmallestValue = 1e-15;
constexpr double kStill = 1e-12;  // m RMS; so is what moves less

// G_fg = sum over vertices of (x_f - mean) . (x_g - mean)
Eigen::MatrixXd scalar_products(const std::vector<const std::vector<Vec3>*>& frames) {
  const auto n = static_cast<Eigen::Index>(frames.size());
  std::vector<Vec3> mean =
      combine(std::vector<double>(frames.size(), 1.0 / static_cast<double>(n)), frames);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index f = 0; f < n; ++f) {
    for (Eigen::Index g = 0; g <= f; ++g) {
      double sum = 0.0;
      for (std::size_t v = 0; v < mean.size(); ++v) {
        sum += ((*frames[f])[v] - mean[v]).dot((*frames[g])[v] - mean[v]);
      }
      products(f, g) = products(g, f) = sum;
    }
  }
  return products;
}

}  // namespace

std::vector<Vec3> combine(const std::vector<double>& factors,
                          const std::vector<const std::vector<Vec3>*>& frames) {
  std::vector<Vec3> sum(frames.front()->size(), Vec3::Zero());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += factors[f] * (*frames[f])[v];
  }
  return sum;
}

// x_f = mean + sum_k u_fk m_k with the mode m_k = sum_g u_gk (x_g - mean), u_k an eigenvector of
// length 1. With low_k and high_k the least and largest u_fk, the weight (u_fk - low_k) /
// (high_k - low_k) lies in 0..1, the target is (high_k - low_k) m_k and the base mean + sum_k low_k
// m_k. As sum_f u_fk = 0, m_k = sum_g u_gk x_g.
MotionBasis fit_motion_basis(const std::vector<const std::vector<Vec3>*>& frames, int count) {
  const std::size_t n = frames.size();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scalar_products(frames));
  const double values = static_cast<double>(n * frames.front()->size());
  const double least =
      std::max(kSmallestValue * solver.eigenvalues().tail(1)[0], kStill * kStill * values);
  MotionBasis basis;
  basis.base_factors.assign(n, 1.0 / static_cast<double>(n));
  basis.weights.resize(n);
  for (Eigen::Index k = static_cast<Eigen::Index>(n) - 1; k >= 0; --k) {
    const double value = solver.eigenvalues()[k];
    if (static_cast<int>(basis.factors.size()) == count || value <= least) break;
    Eigen::VectorXd mode = solver.eigenvectors().col(k);
    mode.array() -= mode.mean();
    const double low = mode.minCoeff(), range = mode.maxCoeff() - low;
    auto& factors = basis.factors.emplace_back(n);
    for (std::size_t f = 0; f < n; ++f) {
      const double u = mode[static_cast<Eigen::Index>(f)];
      factors[f] = range * u;
      basis.base_factors[f] += low * u;
      basis.weights[f].push_back(static_cast<float>(std::clamp((u - low) / range, 0.0, 1.0)));
    }
  }
  return basis;
}

// The pseudo-inverse (WᵀW)⁻¹Wᵀ of the weights W.
std::vector<std::vector<double>> least_squares_factors(
    const std::vector<std::vector<float>>& weights) {
  const auto rows = static_cast<Eigen::Index>(weights.size());
  const auto columns = static_cast<Eigen::Index>(weights.front().size());
  if (columns == 0) return {};  // nothing moves
  Eigen::MatrixXd w(rows, columns);
  for (Eigen::Index f = 0; f < rows; ++f) {
    for (Eigen::Index k = 0; k < columns; ++k) w(f, k) = double{weights[f][k]};
  }
  const Eigen::MatrixXd inverse = (w.transpose() * w).ldlt().solve(Eigen::MatrixXd(w.transpose()));
  std::vector<std::vector<double>> factors(static_cast<std::size_t>(columns));
  for (Eigen::Index k = 0; k < columns; ++k) {
    for (Eigen::Index f = 0; f < rows; ++f) factors[k].push_back(inverse(k, f));
  }
  return factors;
}

}  // namespace thew::tools
