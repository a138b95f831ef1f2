// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/elements/fem_bar.h"

#include <cmath>
#include <map>

#include "tools/lab/elements/fem_ball.h"

namespace thew::tools {

double bar_thinning(double neck, double u) {
  const double near = 1.0 / (1.0 + 16.0 * u * u);
  return 1.0 - neck * near * near;
}

FemBody quarter_bar(const BarShape& shape, int n, int m, const FemMaterial& material) {
  // Sections i + j <= 2 n of lattice points, as octant_ball has them, 2 m + 1 of them along x.
  FemBody body;
  body.order = 2;
  body.material = material;
  std::map<std::array<int, 3>, int> index;
  const auto node = [&](const std::array<int, 3>& at) {
    const auto [found, added] = index.try_emplace(at, static_cast<int>(body.rest.size()));
    if (!added) return found->second;
    const double x = shape.held * (at[2] - m) / m, u = x / shape.half.x();
    const Vec3 p(0.0, at[0], at[1]);
    const double around = p.norm() > 0.0 ? p.sum() / (2 * n * p.norm()) : 0.0;
    const double size = around * std::sqrt(1.0 - u * u) * bar_thinning(shape.neck, u);
    body.rest.push_back(Vec3(x, 0, 0) + size * p.cwiseProduct(shape.half));
    body.surface.push_back(at[0] + at[1] == 2 * n);
    const bool end = at[2] == 0 || at[2] == 2 * m;
    for (bool fixed : {end, end || at[0] == 0, end || at[1] == 0}) body.fixed.push_back(fixed);
    return found->second;
  };
  // Kuhn's tetrahedra of the partial sums u >= v, and of the layers.
  for (int cell = 0; cell < n * n * m; ++cell) {
    const int u = cell % n, v = cell / n % n, w = cell / (n * n);
    for (const auto& order : kKuhnOrders) {
      std::array<std::array<int, 3>, 4> c;
      int at[3] = {u, v, w};
      bool inside = true;
      for (int k = 0; k < 4; ++k) {
        if (k > 0) ++at[order[k - 1]];
        inside = inside && at[0] >= at[1];
        c[k] = {2 * (at[0] - at[1]), 2 * at[1], 2 * at[2]};
      }
      if (inside) add_element(c, node, body);
    }
  }
  prepare(body);
  return body;
}

FemResult squeeze_bar(const BarShape& shape, int steps, FemBody& body) {
  FemResult result;
  for (int i = 1; i <= steps; ++i) {
    FemStep step;
    step.high = shape.half.y() - shape.travel * i / steps;
    step.edge = 0.0;
    step.rounding = shape.rounding;
    step.direct = true;
    step.iterations = 60;
    step.tolerance = 1e-6 * shape.half.y();
    step.firmness = 300.0 * body.material.shear * shape.half.y();
    result = solve_step(body, step);
    if (!result.converged) break;
  }
  return result;
}

}  // namespace thew::tools
