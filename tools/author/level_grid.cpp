// SPDX-License-Identifier: Apache-2.0
#include "tools/author/level_grid.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

// Corners of a cell on one side must hang together along its edges, or sheets of the surface would
// share its one vertex.
bool hangs_together(unsigned corners) {
  unsigned reached = corners & (~corners + 1);  // the lowest
  for (int pass = 0; pass < 7; ++pass) {
    for (int corner = 0; corner < 8; ++corner) {
      if (!(reached >> corner & 1)) continue;
      for (int axis = 0; axis < 3; ++axis) reached |= corners & 1u << (corner ^ 1 << axis);
    }
  }
  return reached == corners;
}

// Fills the pockets that are too narrow for the grid, until every cell has a single sheet.
bool fill_narrow_cells(LevelGrid& grid) {
  bool filled = false;
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    for (int j = 0; j + 1 < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        unsigned inside = 0;
        double* nearest = nullptr;
        for (int c = 0; c < 8; ++c) {
          double& d = grid.level[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1))];
          inside |= static_cast<unsigned>(d < 0.0) << c;
          if (d >= 0.0 && (!nearest || d < *nearest)) nearest = &d;
        }
        if (hangs_together(inside) && hangs_together(inside ^ 255u)) continue;
        *nearest = -1e-4;
        filled = true;
      }
    }
  }
  return filled;
}

// The mean of the surface's crossings with the edges of a cell, or nothing.
bool cell_vertex(const LevelGrid& grid, int i, int j, int k, Vec3& mean) {
  int crossings = 0;
  mean = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      if (corner >> axis & 1) continue;
      const int other = corner | 1 << axis;
      const auto at = [&](int c) {
        return grid.level[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1))];
      };
      const double a = at(corner), b = at(other);
      if ((a < 0.0) == (b < 0.0)) continue;
      const Vec3 from = grid.point(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2 & 1));
      mean += from + a / (a - b) * grid.cell[axis] * Vec3::Unit(axis);
      ++crossings;
    }
  }
  if (crossings > 0) mean /= crossings;
  return crossings > 0;
}

void add_quad(std::array<int, 4> q, bool flip, TriMesh& mesh) {
  if (flip) std::swap(q[1], q[3]);
  const auto length = [&](int a, int b) {
    return (mesh.vertices[q[a]] - mesh.vertices[q[b]]).norm();
  };
  if (length(0, 2) > length(1, 3)) std::rotate(q.begin(), q.begin() + 1, q.end());
  mesh.triangles.push_back({q[0], q[1], q[2]});
  mesh.triangles.push_back({q[0], q[2], q[3]});
}

}  // namespace

LevelGrid empty_grid(const Vec3& low, const Vec3& high, const Vec3& cell) {
  LevelGrid grid{low, cell, {}, {}};
  for (int a = 0; a < 3; ++a) {
    grid.size[a] = static_cast<int>((high[a] - low[a]) / cell[a]) + 3;
  }
  grid.level.resize(grid.index(0, 0, grid.size[2]));
  return grid;
}

void sample(const Level& level, LevelGrid& grid) {
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        grid.level[grid.index(i, j, k)] = level(grid.point(i, j, k));
      }
    }
  }
}

double level_at(const LevelGrid& grid, const Vec3& p) {
  std::array<int, 3> at;
  Vec3 share;
  for (int a = 0; a < 3; ++a) {
    const double cells = std::clamp((p[a] - grid.low[a]) / grid.cell[a], 0.0, grid.size[a] - 1.001);
    at[a] = static_cast<int>(cells);
    share[a] = cells - at[a];
  }
  double sum = 0.0;
  for (int c = 0; c < 8; ++c) {
    double weight = 1.0;
    for (int a = 0; a < 3; ++a) weight *= c >> a & 1 ? share[a] : 1.0 - share[a];
    sum += weight * grid.level[grid.index(at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2))];
  }
  return sum;
}

Vec3 slope(const Level& level, const Vec3& p, double step) {
  Vec3 g;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = step * Vec3::Unit(k);
    g[k] = (level(p + d) - level(p - d)) / (2.0 * step);
  }
  return g;
}

void blur(int passes, LevelGrid& grid) {
  const std::array<size_t, 3> stride = {1, static_cast<size_t>(grid.size[0]), grid.index(0, 0, 1)};
  for (int pass = 0; pass < passes; ++pass) {
    for (int a = 0; a < 3; ++a) {
      const std::vector<double> before = grid.level;
      for (size_t i = 0; i < before.size(); ++i) {
        const size_t along = i / stride[a] % grid.size[a];
        const double low = before[along > 0 ? i - stride[a] : i];
        const double high =
            before[along + 1 < static_cast<size_t>(grid.size[a]) ? i + stride[a] : i];
        grid.level[i] = 0.25 * (low + high) + 0.5 * before[i];
      }
    }
  }
}

TriMesh surface_nets(LevelGrid& grid) {
  while (fill_narrow_cells(grid)) {
  }
  TriMesh mesh;
  std::vector<int> vertex(grid.level.size(), -1);  // of cells, by their lowest point
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    for (int j = 0; j + 1 < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        Vec3 p;
        if (!cell_vertex(grid, i, j, k, p)) continue;
        vertex[grid.index(i, j, k)] = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(p);
      }
    }
  }
  for (int k = 1; k + 1 < grid.size[2]; ++k) {
    for (int j = 1; j + 1 < grid.size[1]; ++j) {
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        const double here = grid.level[grid.index(i, j, k)];
        for (int axis = 0; axis < 3; ++axis) {
          std::array<int, 3> next = {i, j, k};
          ++next[axis];
          if ((here < 0.0) == (grid.level[grid.index(next[0], next[1], next[2])] < 0.0)) continue;
          const auto cell = [&](int du, int dv) {
            std::array<int, 3> c = {i, j, k};
            c[(axis + 1) % 3] -= du;
            c[(axis + 2) % 3] -= dv;
            return vertex[grid.index(c[0], c[1], c[2])];
          };
          add_quad({cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)}, here >= 0.0, mesh);
        }
      }
    }
  }
  return mesh;
}

}  // namespace thew::tools
