// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/elements/delaunay.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace thew::tools {
namespace {

using Wide = Eigen::Matrix<long double, 3, 1>;

// Face k is opposite corner k and seen from it counter-clockwise from outside.
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Cell {
  Tetrahedron corner;
  std::array<int, 4> across;  // cell beyond each face, -1 none
  bool alive = true;
};

class Builder {
 public:
  explicit Builder(const std::vector<Vec3>& points) {
    for (const Vec3& p : points) points_.push_back(p.cast<long double>());
    const long double far = 1e4L;  // of a cloud about the origin whose size is about 1
    first_far_ = static_cast<int>(points.size());
    points_.push_back({far, far, far});
    points_.push_back({far, -far, -far});
    points_.push_back({-far, far, -far});
    points_.push_back({-far, -far, far});
    Tetrahedron t = {first_far_, first_far_ + 1, first_far_ + 2, first_far_ + 3};
    if (orientation(t[0], t[1], t[2], t[3]) < 0) std::swap(t[2], t[3]);
    cells_.push_back({t, {-1, -1, -1, -1}});
  }

  void insert(int p) {
    std::vector<int> cavity = {locate(p)};
    mark_.resize(cells_.size(), -1);
    mark_[cavity[0]] = p;
    std::vector<std::pair<int, int>> walls;  // (cell, face) of the cavity's boundary
    for (size_t i = 0; i < cavity.size(); ++i) {
      for (int k = 0; k < 4; ++k) {
        const int next = cells_[cavity[i]].across[k];
        if (next >= 0 && mark_[next] == p) continue;
        if (next >= 0 && in_sphere(cells_[next].corner, p)) {
          mark_[next] = p;
          cavity.push_back(next);
        } else {
          walls.push_back({cavity[i], k});
        }
      }
    }
    std::erase_if(walls, [&](const auto& wall) {  // seen as a wall before its cell was taken
      const int next = cells_[wall.first].across[wall.second];
      return next >= 0 && mark_[next] == p;
    });
    fill(p, walls);
    for (int cell : cavity) cells_[cell].alive = false;
  }

  TetMesh result(const std::vector<Vec3>& points) const {
    TetMesh mesh{points, {}};
    for (const Cell& cell : cells_) {
      const bool far = std::any_of(cell.corner.begin(), cell.corner.end(),
                                   [&](int i) { return i >= first_far_; });
      if (cell.alive && !far) mesh.tetrahedra.push_back(cell.corner);
    }
    return mesh;
  }

 private:
  long double orientation(int a, int b, int c, int d) const {
    const Wide o = points_[a];
    return (points_[b] - o).cross(points_[c] - o).dot(points_[d] - o);
  }

  bool in_sphere(const Tetrahedron& t, int p) const {
    Eigen::Matrix<long double, 4, 4> m;
    for (int k = 0; k < 4; ++k) {
      const Wide d = points_[t[k]] - points_[p];
      m.row(k) << d.x(), d.y(), d.z(), d.squaredNorm();
    }
    return m.determinant() < 0;  // of corners in positive order
  }

  int locate(int p) const {
    int cell = last_;
    for (size_t steps = 0; steps < cells_.size(); ++steps) {
      const Cell& at = cells_[cell];
      int next = -2;
      for (int k = 0; k < 4 && next == -2; ++k) {
        const auto& f = kFaces[k];
        if (orientation(at.corner[f[0]], at.corner[f[1]], at.corner[f[2]], p) > 0) {
          next = at.across[k];
        }
      }
      if (next == -2) return cell;
      if (next == -1) break;
      cell = next;
    }
    throw std::runtime_error("delaunay: a point lies outside; scale the cloud to about 1");
  }

  void fill(int p, const std::vector<std::pair<int, int>>& walls) {
    std::map<std::array<int, 2>, std::pair<int, int>> open;  // edge of a wall -> (cell, face)
    for (const auto& [from, face] : walls) {
      const Tetrahedron old = cells_[from].corner;
      const int a = old[kFaces[face][0]], b = old[kFaces[face][1]], c = old[kFaces[face][2]];
      const int beyond = cells_[from].across[face], cell = static_cast<int>(cells_.size());
      if (!(orientation(a, b, c, p) < 0)) throw std::runtime_error("delaunay: flat cavity");
      cells_.push_back({{a, c, b, p}, {-1, -1, -1, beyond}});
      mark_.push_back(-1);
      if (beyond >= 0) {
        for (int k = 0; k < 4; ++k) {
          if (cells_[beyond].across[k] == from) cells_[beyond].across[k] = cell;
        }
      }
      for (int k = 0; k < 3; ++k) {  // the face opposite corner k holds p and the other two
        const Tetrahedron& t = cells_[cell].corner;
        const auto [low, high] = std::minmax(t[(k + 1) % 3], t[(k + 2) % 3]);
        const auto [at, added] = open.try_emplace({low, high}, cell, k);
        if (added) continue;
        cells_[cell].across[k] = at->second.first;
        cells_[at->second.first].across[at->second.second] = cell;
      }
      last_ = cell;
    }
  }

  std::vector<Wide> points_;
  std::vector<Cell> cells_;
  std::vector<int> mark_;
  int first_far_ = 0, last_ = 0;
};

}  // namespace

TetMesh delaunay(const std::vector<Vec3>& points) {
  Builder builder(points);
  for (int i = 0; i < static_cast<int>(points.size()); ++i) builder.insert(i);
  return builder.result(points);
}

std::vector<Triangle> boundary(const TetMesh& mesh) {
  std::map<Triangle, Triangle> single;  // sorted -> as seen from outside
  for (const Tetrahedron& t : mesh.tetrahedra) {
    for (const auto& f : kFaces) {
      const Triangle face = {t[f[0]], t[f[1]], t[f[2]]};
      Triangle key = face;
      std::sort(key.begin(), key.end());
      if (!single.emplace(key, face).second) single.erase(key);
    }
  }
  std::vector<Triangle> out;
  for (const auto& [key, face] : single) out.push_back(face);
  return out;
}

double signed_volume(const TetMesh& mesh, const Tetrahedron& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).dot(mesh.vertices[t[3]] - a) /
         6.0;
}

}  // namespace thew::tools
