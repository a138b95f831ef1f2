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
  std::map<LatticePoint, int> index;
  const auto node = [&](const LatticePoint& at) {
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
  // Of the partial sums u >= v, and of the layers.
  const auto place = [](const LatticePoint& sums) {
    return LatticePoint{2 * (sums[0] - sums[1]), 2 * sums[1], 2 * sums[2]};
  };
  for (int cell = 0; cell < n * n * m; ++cell) {
    add_kuhn_cell({cell % n, cell / n % n, cell / (n * n)}, place, node, body);
  }
  prepare(body);
  return body;
}

FemResult squeeze_bar(const BarShape& shape, int steps, FemBody& body) {
  const double thick = shape.half.y();
  return close_planes(thick, thick - shape.travel, steps, {.edge = 0.0, .rounding = shape.rounding},
                      body);
}

}  // namespace thew::tools
