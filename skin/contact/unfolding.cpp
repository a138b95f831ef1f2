// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/unfolding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rig/math.h"

namespace thew::skin {
namespace {

constexpr double kFolded = 0.087;  // cosine of 85 degrees

// The corners of the two triangles at an edge: its ends, then those opposite.
std::array<int, 4> corners_of(const Surface& surface, int triangle, int side) {
  const Triangle& t = surface.triangles[triangle];
  const Triangle& other = surface.triangles[surface.neighbours[triangle][side]];
  const int a = t[side], b = t[(side + 1) % 3];
  return {a, b, t[(side + 2) % 3], other[0] + other[1] + other[2] - a - b};
}

// The two triangles at an edge, and how sharp it is.
struct Hinge {
  std::array<Vec3, 4> at;  // m: ends, opposite corners
  Vec3 one, two;           // m^2, twice the area vectors

  template <typename Position>
  Hinge(const std::array<int, 4>& corners, const Position& position) {
    for (int k = 0; k < 4; ++k) at[k] = position(corners[k]);
    one = (at[1] - at[0]).cross(at[2] - at[0]);
    two = (at[0] - at[1]).cross(at[3] - at[1]);
  }
  double cosine() const {
    const double lengths = one.norm() * two.norm();
    return lengths > 0.0 ? std::clamp(one.dot(two) / lengths, -1.0, 1.0) : 1.0;
  }
  bool is_valley() const { return one.dot(at[3] - at[0]) > 0.0; }
  // By corner, of the angle between the normals (Bridson, Marino, Fedkiw 2003, section 4), 1/m.
  std::array<Vec3, 4> gradient() const {
    const Vec3 edge = at[1] - at[0];
    const double length = edge.norm(), sign = is_valley() ? 1.0 : -1.0;
    const Vec3 c = sign * length / one.squaredNorm() * one;
    const Vec3 d = sign * length / two.squaredNorm() * two;
    const double of_c = (at[2] - at[0]).dot(edge) / (length * length);
    const double of_d = (at[3] - at[0]).dot(edge) / (length * length);
    return {(of_c - 1.0) * c + (of_d - 1.0) * d, -of_c * c - of_d * d, c, d};
  }
};

Hinge hinge_now(const Collider& body, const std::array<int, 4>& corners) {
  return Hinge(corners, [&](int node) { return to_vec((*body.x)[node]); });
}

double cosine_at_rest(const std::vector<Vec3>& rest, const std::array<int, 4>& corners) {
  return Hinge(corners, [&](int node) { return rest[node]; }).cosine();
}

double angle_of(double cosine) {
  return arc_tan2(std::sqrt(std::max(1.0 - cosine * cosine, 0.0)), cosine);
}

}  // namespace

void find_folded_edges(const Collider& body, const std::vector<Vec3>& rest, FoldWork& work) {
  constexpr double kNearlyFolded = 1.01 * kFolded;  // and then looked at one by one
  const Surface& surface = *body.surface;
  const Points& x = *body.x;
  const int triangles = static_cast<int>(surface.triangles.size());
  work.edges.clear();
  work.areas.resize(triangles);
  for (int t = 0; t < triangles; ++t) {
    const Triangle& c = surface.triangles[t];
    work.areas[t] = cross3(x[c[1]] - x[c[0]], x[c[2]] - x[c[0]]);
  }
  const auto may_be_folded = [&](const Point& a, const Point& b) {
    const double along = dot(a, b);
    return along < 0.0 || along * along < kNearlyFolded * kNearlyFolded * (dot(a, a) * dot(b, b));
  };
  for (int t = 0; t < triangles; ++t) {
    for (int side = 0; side < 3; ++side) {
      const int other = surface.neighbours[t][side];
      if (other <= t) continue;  // from its other side, or a border
      if (!may_be_folded(work.areas[t], work.areas[other])) continue;
      const std::array<int, 4> corners = corners_of(surface, t, side);
      const double cosine = hinge_now(body, corners).cosine();
      if (cosine >= kFolded) continue;
      if (std::none_of(corners.begin(), corners.end(), [&](int i) { return is_free(body, i); })) {
        continue;
      }
      const double at_rest = cosine_at_rest(rest, corners);
      if (at_rest > 0.0 && cosine < at_rest) work.edges.push_back({t, side});
    }
  }
}

void push_open(const Collider& body, const std::vector<Vec3>& rest,
               const std::vector<FoldedEdge>& edges, double longest, Parting& parting) {
  constexpr double kBeyond = 1.2;  // of what would do: corners go the mean of what edges ask
  for (const FoldedEdge& edge : edges) {
    const std::array<int, 4> corners = corners_of(*body.surface, edge.triangle, edge.side);
    const Hinge hinge = hinge_now(body, corners);
    const double wanted = angle_of(std::min(kFolded, cosine_at_rest(rest, corners)));
    const std::array<Vec3, 4> gradient = hinge.gradient();
    double squares = 0.0;
    for (int k = 0; k < 4; ++k) {
      if (is_free(body, corners[k])) squares += gradient[k].squaredNorm();
    }
    if (!(squares > 0.0)) continue;
    const double by = kBeyond * (angle_of(hinge.cosine()) - wanted) / squares;
    for (int k = 0; k < 4; ++k) push(body, corners[k], 1.0, -by * gradient[k], longest, parting);
  }
}

}  // namespace thew::skin
