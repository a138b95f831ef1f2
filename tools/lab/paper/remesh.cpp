// SPDX-License-Identifier: Apache-2.0
//
// A surface from a field, and a surface brought to a count of triangles.
#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

struct Remesher {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  std::vector<char> alive;
  std::vector<std::set<int>> around;  // triangles by vertex
  int count = 0;

  explicit Remesher(const TriMesh& mesh) : x(mesh.vertices), around(mesh.vertices.size()) {
    for (const Triangle& t : mesh.triangles) add(t);
  }

  void add(const Triangle& t) {
    for (int corner : t) around[corner].insert(static_cast<int>(triangles.size()));
    triangles.push_back(t);
    alive.push_back(1);
    ++count;
  }

  void remove(int t) {
    for (int corner : triangles[t]) around[corner].erase(t);
    alive[t] = 0;
    --count;
  }

  std::set<int> neighbours(int v) const {
    std::set<int> out;
    for (int t : around[v]) out.insert(triangles[t].begin(), triangles[t].end());
    out.erase(v);
    return out;
  }

  std::vector<int> triangles_of(int a, int b) const {
    std::vector<int> out;
    std::set_intersection(around[a].begin(), around[a].end(), around[b].begin(), around[b].end(),
                          std::back_inserter(out));
    return out;
  }

  // No triangle about `v` but those of the edge may turn or vanish when v goes to p.
  bool keeps_facing(int v, int other, const Vec3& p) const {
    for (int t : around[v]) {
      Triangle c = triangles[t];
      if (std::find(c.begin(), c.end(), other) != c.end()) continue;
      const auto normal = [&] { return Vec3((x[c[1]] - x[c[0]]).cross(x[c[2]] - x[c[0]])); };
      const Vec3 before = normal();
      Vec3 corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = c[k] == v ? p : x[c[k]];
      const Vec3 after = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
      if (before.dot(after) < 0.3 * before.norm() * after.norm() + 1e-30) return false;
    }
    return true;
  }

  bool collapse(int a, int b) {
    const std::set<int> near_a = neighbours(a), near_b = neighbours(b);
    std::vector<int> common;
    std::set_intersection(near_a.begin(), near_a.end(), near_b.begin(), near_b.end(),
                          std::back_inserter(common));
    if (common.size() != 2) return false;  // the surface would pinch
    for (int c : common) {
      if (around[c].size() < 4) return false;
    }
    const Vec3 middle = 0.5 * (x[a] + x[b]);
    if (!keeps_facing(a, b, middle) || !keeps_facing(b, a, middle)) return false;
    for (int t : triangles_of(a, b)) remove(t);
    const std::set<int> moved = around[b];
    for (int t : moved) {
      Triangle c = triangles[t];
      std::replace(c.begin(), c.end(), b, a);
      triangles[t] = c;
      around[a].insert(t);
    }
    around[b].clear();
    x[a] = middle;
    return true;
  }

  int split(int a, int b) {
    const int middle = static_cast<int>(x.size());
    x.push_back(0.5 * (x[a] + x[b]));
    around.emplace_back();
    for (int t : triangles_of(a, b)) {
      Triangle first = triangles[t], second = first;
      std::replace(first.begin(), first.end(), a, middle);
      std::replace(second.begin(), second.end(), b, middle);
      remove(t);
      add(first);
      add(second);
    }
    return middle;
  }

  TriMesh result() const {
    TriMesh mesh;
    std::vector<int> number(x.size(), -1);
    for (size_t t = 0; t < triangles.size(); ++t) {
      if (!alive[t]) continue;
      Triangle out;
      for (int k = 0; k < 3; ++k) {
        int& n = number[triangles[t][k]];
        if (n < 0) {
          n = static_cast<int>(mesh.vertices.size());
          mesh.vertices.push_back(x[triangles[t][k]]);
        }
        out[k] = n;
      }
      mesh.triangles.push_back(out);
    }
    return mesh;
  }
};

struct Edge {
  double length;
  int a, b;
  bool operator<(const Edge& o) const {
    return std::tie(length, a, b) < std::tie(o.length, o.a, o.b);
  }
};

// Edges of a sign: the longest first (+1) or the shortest (-1); stale entries are told by length.
class EdgeQueue {
 public:
  EdgeQueue(const Remesher& mesh, double sign) : mesh_(mesh), sign_(sign) {
    for (int v = 0; v < static_cast<int>(mesh.x.size()); ++v) push_around(v);
  }
  void push_around(int v) {
    for (int other : mesh_.neighbours(v)) {
      queue_.push(
          {sign_ * (mesh_.x[v] - mesh_.x[other]).norm(), std::min(v, other), std::max(v, other)});
    }
  }
  bool pop(Edge& edge) {
    while (!queue_.empty()) {
      edge = queue_.top();
      queue_.pop();
      const bool fresh = edge.length == sign_ * (mesh_.x[edge.a] - mesh_.x[edge.b]).norm();
      if (fresh && !mesh_.triangles_of(edge.a, edge.b).empty()) return true;
    }
    return false;
  }

 private:
  const Remesher& mesh_;
  double sign_;
  std::priority_queue<Edge> queue_;
};

}  // namespace

TriMesh with_count(const TriMesh& mesh, int triangles) {
  Remesher work(mesh);
  Edge edge;
  EdgeQueue shortest(work, -1.0);
  while (work.count > triangles) {
    if (!shortest.pop(edge)) {
      throw Error(ErrorCode::kInput, "the mesh cannot be brought down to " +
                                         std::to_string(triangles) + " triangles; " +
                                         std::to_string(work.count) + " are left");
    }
    if (work.collapse(edge.a, edge.b)) shortest.push_around(edge.a);
  }
  EdgeQueue longest(work, 1.0);
  while (work.count < triangles && longest.pop(edge)) {
    const int middle = work.split(edge.a, edge.b);
    longest.push_around(middle);
  }
  if (work.count != triangles) {
    throw Error(ErrorCode::kInput, "a closed surface has an even number of triangles; " +
                                       std::to_string(triangles) + " cannot be reached");
  }
  return work.result();
}

TriMesh polygonise(const std::function<double(const Vec3&)>& field, const Vec3& low,
                   const Vec3& high, double cell) {
  int n[3];
  for (int k = 0; k < 3; ++k) n[k] = static_cast<int>(std::ceil((high[k] - low[k]) / cell)) + 1;
  const auto id = [&](int i, int j, int k) { return (i * n[1] + j) * n[2] + k; };
  const auto place = [&](int at) {
    const int i = at / (n[1] * n[2]), j = at / n[2] % n[1], k = at % n[2];
    return Vec3(low + cell * Vec3(i, j, k));
  };
  std::vector<double> value(static_cast<size_t>(n[0]) * n[1] * n[2]);
  for (size_t at = 0; at < value.size(); ++at) value[at] = field(place(static_cast<int>(at)));
  TriMesh mesh;
  std::map<std::array<int, 2>, int> crossing;
  const auto cut = [&](int a, int b) {
    const auto [lowest, highest] = std::minmax(a, b);
    const auto [found, added] =
        crossing.try_emplace({lowest, highest}, static_cast<int>(mesh.vertices.size()));
    if (added) {
      // Kept off the corners: no edge of length zero.
      const double t = std::clamp(value[lowest] / (value[lowest] - value[highest]), 0.1, 0.9);
      mesh.vertices.push_back(place(lowest) + t * (place(highest) - place(lowest)));
    }
    return found->second;
  };
  const auto add = [&](int a, int b, int c, const Vec3& outside) {
    const Vec3& p = mesh.vertices[a];
    const Vec3 normal = (mesh.vertices[b] - p).cross(mesh.vertices[c] - p);
    if (normal.dot(outside - p) < 0.0) std::swap(b, c);
    mesh.triangles.push_back({a, b, c});
  };
  // A cube is six tetrahedra about its diagonal (Kuhn), one for each order of the axes.
  for (int i = 0; i + 1 < n[0]; ++i) {
    for (int j = 0; j + 1 < n[1]; ++j) {
      for (int k = 0; k + 1 < n[2]; ++k) {
        for (const auto& order : kKuhnOrders) {
          int step[3] = {i, j, k}, corner[4] = {id(i, j, k)};
          for (int s = 0; s < 3; ++s) {
            ++step[order[s]];
            corner[s + 1] = id(step[0], step[1], step[2]);
          }
          std::vector<int> in, out;
          for (int c : corner) (value[c] < 0.0 ? in : out).push_back(c);
          if (in.empty() || out.empty()) continue;
          const Vec3 outside = place(out[0]);
          if (in.size() == 1) {
            add(cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2]), outside);
          } else if (out.size() == 1) {
            add(cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0]), outside);
          } else {
            const int a = cut(in[0], out[0]), b = cut(in[0], out[1]);
            const int c = cut(in[1], out[1]), d = cut(in[1], out[0]);
            add(a, b, c, outside);
            add(a, c, d, outside);
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace thew::tools
