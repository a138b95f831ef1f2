// SPDX-License-Identifier: Apache-2.0
#include "tools/author/remesh.h"

#include <algorithm>
#include <cmath>

#include "tools/base/obj_text.h"

namespace thew::tools {
namespace {

constexpr double kLeastFacing = 0.5;  // cosine, most that a change may turn a triangle

struct Work {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;       // those that are gone have the corner -1
  std::vector<std::vector<int>> around;  // triangles by vertex, in order

  bool is_gone(int t) const { return triangles[t][0] < 0; }
  Vec3 area(const Triangle& t) const { return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]); }

  void attach(int t) {
    for (int v : triangles[t]) {
      std::vector<int>& list = around[v];
      list.insert(std::lower_bound(list.begin(), list.end(), t), t);
    }
  }
  void detach(int t) {
    for (int v : triangles[t]) {
      std::vector<int>& list = around[v];
      list.erase(std::lower_bound(list.begin(), list.end(), t));
    }
  }
  void replace(int t, int from, int to) {
    detach(t);
    std::replace(triangles[t].begin(), triangles[t].end(), from, to);
    attach(t);
  }
  void remove(int t) {
    detach(t);
    triangles[t] = {-1, -1, -1};
  }
  void add(const Triangle& t) {
    triangles.push_back(t);
    attach(static_cast<int>(triangles.size()) - 1);
  }

  std::vector<int> neighbours(int v) const {
    std::vector<int> out;
    for (int t : around[v]) {
      for (int c : triangles[t]) {
        if (c != v) out.push_back(c);
      }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
  // The two triangles of an edge; the first has it as a, b in its order.
  std::array<int, 2> sides(int a, int b) const {
    std::array<int, 2> out = {-1, -1};
    for (int t : around[a]) {
      for (int k = 0; k < 3; ++k) {
        if (triangles[t][k] == a && triangles[t][(k + 1) % 3] == b) out[0] = t;
        if (triangles[t][k] == b && triangles[t][(k + 1) % 3] == a) out[1] = t;
      }
    }
    return out;
  }
  int opposite(int t, int a, int b) const {
    return triangles[t][0] + triangles[t][1] + triangles[t][2] - a - b;
  }
  std::vector<std::array<int, 2>> edges() const {
    std::vector<std::array<int, 2>> out;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
      for (int k = 0; k < 3 && !is_gone(t); ++k) {
        const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
        if (a < b) out.push_back({a, b});
      }
    }
    return out;
  }
};

bool faces_alike(const Vec3& before, const Vec3& after) {
  return after.norm() > 1e-14 && before.dot(after) > kLeastFacing * before.norm() * after.norm();
}

void split_long(const Level& wanted, Work& work) {
  for (const auto& [a, b] : work.edges()) {
    const Vec3 middle = 0.5 * (work.x[a] + work.x[b]);
    if ((work.x[a] - work.x[b]).norm() < 4.0 / 3.0 * wanted(middle)) continue;
    const int v = static_cast<int>(work.x.size());
    work.x.push_back(middle);
    work.around.emplace_back();
    for (int t : work.sides(a, b)) {
      Triangle half = work.triangles[t];
      std::replace(half.begin(), half.end(), a, v);
      work.replace(t, b, v);
      work.add(half);
    }
  }
}

// Whether the triangles around v, but those with `without`, face as before when v goes to p.
bool may_move(const Work& work, int v, int without, const Vec3& p) {
  for (int t : work.around[v]) {
    const Triangle& corners = work.triangles[t];
    if (std::find(corners.begin(), corners.end(), without) != corners.end()) continue;
    std::array<Vec3, 3> at;
    for (int k = 0; k < 3; ++k) at[k] = corners[k] == v ? p : work.x[corners[k]];
    if (!faces_alike(work.area(corners), (at[1] - at[0]).cross(at[2] - at[0]))) return false;
  }
  return true;
}

bool may_collapse(const Work& work, int a, int b, const Vec3& p) {
  const std::vector<int> of_a = work.neighbours(a), of_b = work.neighbours(b);
  std::vector<int> both;
  std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                        std::back_inserter(both));
  if (both.size() != 2) return false;  // the surface would pinch
  for (int v : both) {
    if (work.around[v].size() < 4) return false;
  }
  return may_move(work, a, b, p) && may_move(work, b, a, p);
}

void collapse_short(const Level& wanted, Work& work) {
  for (const auto& [a, b] : work.edges()) {
    const std::array<int, 2> sides = work.sides(a, b);
    if (sides[0] < 0 || sides[1] < 0) continue;  // went with another edge
    const Vec3 middle = 0.5 * (work.x[a] + work.x[b]);
    const double most = 4.0 / 5.0 * wanted(middle);
    if ((work.x[a] - work.x[b]).norm() > most || !may_collapse(work, a, b, middle)) continue;
    for (int t : sides) work.remove(t);
    work.x[a] = middle;
    const std::vector<int> moved = work.around[b];
    for (int t : moved) work.replace(t, b, a);
  }
}

// Flips edges where that brings their four corners nearer to six triangles each.
void flip(Work& work) {
  for (const auto& [a, b] : work.edges()) {
    const auto [left, right] = work.sides(a, b);
    if (left < 0 || right < 0) continue;
    const int c = work.opposite(left, a, b), d = work.opposite(right, a, b);
    if (work.sides(c, d)[0] >= 0 || work.sides(d, c)[0] >= 0) continue;
    const auto off = [&](int v, int change) {
      const int excess = static_cast<int>(work.around[v].size()) + change - 6;
      return excess * excess;
    };
    const int before = off(a, 0) + off(b, 0) + off(c, 0) + off(d, 0);
    if (off(a, -1) + off(b, -1) + off(c, 1) + off(d, 1) >= before) continue;
    const Vec3 mean = work.area(work.triangles[left]) + work.area(work.triangles[right]);
    const Triangle first = {c, d, b}, second = {d, c, a};
    if (!faces_alike(mean, work.area(first)) || !faces_alike(mean, work.area(second))) continue;
    work.remove(left);
    work.remove(right);
    work.add(first);
    work.add(second);
  }
}

// Towards the middle of the neighbours, then back onto the surface.
void shift(const Level& level, double share, Work& work) {
  const std::vector<Vec3> before = work.x;
  for (size_t v = 0; v < before.size(); ++v) {
    const std::vector<int> near = work.neighbours(static_cast<int>(v));
    if (near.empty()) continue;
    Vec3 mean = Vec3::Zero();
    for (int n : near) mean += before[n] / static_cast<double>(near.size());
    Vec3 p = before[v] + share * (mean - before[v]);
    for (int step = 0; step < 3; ++step) {
      const Vec3 g = slope(level, p, 5e-4);
      p -= std::clamp(level(p), -0.001, 0.001) / std::max(g.squaredNorm(), 0.3) * g;
    }
    if (may_move(work, static_cast<int>(v), -1, p)) work.x[v] = p;
  }
}

}  // namespace

TriMesh remeshed(const TriMesh& mesh, const Level& wanted, const Level& level) {
  constexpr int kRounds = 10;
  Work work;
  work.x = mesh.vertices;
  work.around.resize(work.x.size());
  for (const Triangle& t : mesh.triangles) work.add(t);
  for (int round = 0; round < kRounds; ++round) {
    split_long(wanted, work);
    collapse_short(wanted, work);
    flip(work);
    for (int k = 0; k < 3; ++k) shift(level, 0.6, work);
  }
  std::erase_if(work.triangles, [](const Triangle& t) { return t[0] < 0; });
  return in_order_of_use({work.x, work.triangles});
}

void smooth_folds(TriMesh& mesh) {
  constexpr int kPasses = 60, kAlone = 50;  // what is left after these takes its neighbours along
  constexpr double kSharpest = 0.34, kShare = 0.3;  // cosine; of the way to the neighbours' middle
  Work work;
  work.x = mesh.vertices;
  work.around.resize(work.x.size());
  for (const Triangle& t : mesh.triangles) work.add(t);
  const std::vector<std::array<int, 2>> edges = work.edges();
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<char> folded(work.x.size(), 0);
    for (const auto& [a, b] : edges) {
      const auto [left, right] = work.sides(a, b);
      const Vec3 u = work.area(work.triangles[left]), v = work.area(work.triangles[right]);
      if (u.dot(v) >= kSharpest * u.norm() * v.norm()) continue;
      for (int t : {left, right}) {
        for (int node : work.triangles[t]) folded[node] = 1;
      }
    }
    if (std::find(folded.begin(), folded.end(), 1) == folded.end()) break;
    const std::vector<char> alone = folded;
    for (size_t v = 0; pass >= kAlone && v < alone.size(); ++v) {
      if (!alone[v]) continue;
      for (int n : work.neighbours(static_cast<int>(v))) folded[n] = 1;
    }
    for (size_t v = 0; v < folded.size(); ++v) {
      if (!folded[v]) continue;
      const std::vector<int> near = work.neighbours(static_cast<int>(v));
      Vec3 mean = Vec3::Zero();
      for (int n : near) mean += work.x[n] / static_cast<double>(near.size());
      work.x[v] += kShare * (mean - work.x[v]);
    }
  }
  mesh.vertices = work.x;
}

}  // namespace thew::tools
