// SPDX-License-Identifier: Apache-2.0
#include "tools/author/bones.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

double stroke_distance(const BoneStroke& s, const Vec3& p) {
  const Vec3 axis = s.to - s.from;
  const double length2 = axis.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(axis.dot(p - s.from) / length2, 0.0, 1.0) : 0.0;
  const Vec3 v = p - s.from - t * axis;
  const double along = v.dot(s.flat_along);
  const double shrunk = v.squaredNorm() - (1.0 - 1.0 / (s.flat * s.flat)) * along * along;
  return std::sqrt(std::max(shrunk, 0.0)) - (s.from_radius + t * (s.to_radius - s.from_radius));
}

// The smaller of two distances, rounded where they are within `blend` of one another.
double melt(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * blend * h * h;
}

Vec3 gradient(const BoneShape& bone, const Vec3& p) {
  constexpr double kStep = 1e-4;  // m
  Vec3 g;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = kStep * Vec3::Unit(k);
    g[k] = (bone_distance(bone, p + d) - bone_distance(bone, p - d)) / (2.0 * kStep);
  }
  return g;
}

// Surface nets (Gibson 1998): a vertex in every cell that the surface crosses, a quad across every
// edge of the grid that it crosses.
struct Grid {
  Vec3 low, cell;
  std::array<int, 3> size;       // samples
  std::vector<double> distance;  // at samples
  std::vector<int> vertex;       // of cells, by their lowest sample

  size_t index(int i, int j, int k) const {
    return (static_cast<size_t>(k) * size[1] + j) * size[0] + i;
  }
  Vec3 point(int i, int j, int k) const { return low + cell.cwiseProduct(Vec3(i, j, k)); }
};

Grid sample(const BoneShape& bone) {
  Grid grid;
  Vec3 high = Vec3::Constant(-1e9);
  grid.low = Vec3::Constant(1e9);
  for (const BoneStroke& s : bone.strokes) {
    const double reach = s.flat * std::max(s.from_radius, s.to_radius);
    grid.low = grid.low.cwiseMin(s.from.cwiseMin(s.to) - Vec3::Constant(reach));
    high = high.cwiseMax(s.from.cwiseMax(s.to) + Vec3::Constant(reach));
  }
  grid.cell = bone.cell;
  grid.low -= 1.7 * grid.cell;
  for (int a = 0; a < 3; ++a) {
    grid.size[a] = static_cast<int>((high[a] - grid.low[a]) / grid.cell[a]) + 3;
  }
  grid.distance.resize(grid.index(0, 0, grid.size[2]));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        grid.distance[grid.index(i, j, k)] = bone_distance(bone, grid.point(i, j, k));
      }
    }
  }
  return grid;
}

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
bool fill_narrow_cells(Grid& grid) {
  bool filled = false;
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    for (int j = 0; j + 1 < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        unsigned inside = 0;
        double* nearest = nullptr;
        for (int c = 0; c < 8; ++c) {
          double& d = grid.distance[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1))];
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
bool cell_vertex(const Grid& grid, int i, int j, int k, Vec3& mean) {
  int crossings = 0;
  mean = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      if (corner >> axis & 1) continue;
      const int other = corner | 1 << axis;
      const auto at = [&](int c) {
        return grid.distance[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1))];
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

TriMesh surface_nets(Grid& grid) {
  TriMesh mesh;
  grid.vertex.assign(grid.distance.size(), -1);
  for (int k = 0; k + 1 < grid.size[2]; ++k) {
    for (int j = 0; j + 1 < grid.size[1]; ++j) {
      for (int i = 0; i + 1 < grid.size[0]; ++i) {
        Vec3 p;
        if (!cell_vertex(grid, i, j, k, p)) continue;
        grid.vertex[grid.index(i, j, k)] = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(p);
      }
    }
  }
  for (int k = 1; k + 1 < grid.size[2]; ++k) {
    for (int j = 1; j + 1 < grid.size[1]; ++j) {
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        const double here = grid.distance[grid.index(i, j, k)];
        for (int axis = 0; axis < 3; ++axis) {
          std::array<int, 3> next = {i, j, k};
          ++next[axis];
          if ((here < 0.0) == (grid.distance[grid.index(next[0], next[1], next[2])] < 0.0))
            continue;
          const auto cell = [&](int du, int dv) {
            std::array<int, 3> c = {i, j, k};
            c[(axis + 1) % 3] -= du;
            c[(axis + 2) % 3] -= dv;
            return grid.vertex[grid.index(c[0], c[1], c[2])];
          };
          add_quad({cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)}, here >= 0.0, mesh);
        }
      }
    }
  }
  return mesh;
}

// Evens out the triangles: towards the mean of the neighbours, then back onto the surface.
void relax(const BoneShape& bone, TriMesh& mesh) {
  constexpr int kPasses = 8;  // and one that only smooths
  for (int pass = 0; pass <= kPasses; ++pass) {
    std::vector<Vec3> sum(mesh.vertices.size(), Vec3::Zero());
    std::vector<int> count(mesh.vertices.size(), 0);
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += mesh.vertices[t[(k + 1) % 3]];
        ++count[t[k]];
      }
    }
    for (size_t i = 0; i < sum.size(); ++i) {
      Vec3& p = mesh.vertices[i];
      p += (pass < kPasses ? 0.4 : 0.15) * (sum[i] / count[i] - p);
      if (pass == kPasses) continue;  // the last one takes out what is left of creases
      const Vec3 g = gradient(bone, p);
      // Short steps: in a crease the slope says little.
      p -= std::clamp(bone_distance(bone, p), -0.001, 0.001) / std::max(g.squaredNorm(), 0.5) * g;
    }
  }
}

}  // namespace

double bone_distance(const BoneShape& bone, const Vec3& p) {
  double d = 1e9;
  for (const BoneStroke& s : bone.strokes) d = melt(d, stroke_distance(s, p), bone.blend);
  for (const BoneStroke& s : bone.hollows) d = -melt(-d, stroke_distance(s, p), 0.25 * bone.blend);
  return d;
}

TriMesh bone_mesh(const BoneShape& bone) {
  Grid grid = sample(bone);
  while (fill_narrow_cells(grid)) {
  }
  TriMesh mesh = surface_nets(grid);
  relax(bone, mesh);
  return mesh;
}

}  // namespace thew::tools
