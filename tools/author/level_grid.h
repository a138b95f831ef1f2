// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

/// A function of space whose zero is a surface: negative inside, about the distance (m) near it.
using Level = std::function<double(const Vec3&)>;

/// A level at the points of a grid.
struct LevelGrid {
  Vec3 low, cell;             ///< m
  std::array<int, 3> size;    ///< points along each axis
  std::vector<double> level;  ///< m, at the points

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * size[1] + j) * size[0] + i;
  }
  Vec3 point(int i, int j, int k) const { return low + cell.cwiseProduct(Vec3(i, j, k)); }
};

/// The grid over a box, from `low` to at least a cell beyond `high`, without values.
LevelGrid empty_grid(const Vec3& low, const Vec3& high, const Vec3& cell);
void sample(const Level& level, LevelGrid& grid);

/// Between the points, linear along each axis; beyond the grid that of its border.
double level_at(const LevelGrid& grid, const Vec3& p);
/// Slope of a level by central differences of `step` m.
Vec3 slope(const Level& level, const Vec3& p, double step);

/// The mean over each point and its two neighbours along each axis in turn (1:2:1), `passes` times:
/// about a Gaussian of sqrt(passes / 2) cells.
void blur(int passes, LevelGrid& grid);

/// The surface of level 0, closed if the grid contains it, by surface nets (Gibson 1998): a vertex
/// in every cell that the surface crosses, a quad across every edge of the grid that it crosses.
/// Pockets too narrow for the grid are filled first.
TriMesh surface_nets(LevelGrid& grid);

}  // namespace thew::tools
