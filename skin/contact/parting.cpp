// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/parting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "skin/contact/contact.h"

namespace thew::skin {
namespace {

bool has_free_corner(const Collider& body, int triangle) {
  const Triangle& t = body.surface->triangles[triangle];
  return is_free(body, t[0]) || is_free(body, t[1]) || is_free(body, t[2]);
}

using Corners = std::array<Vec3, 3>;

Corners corners_of(const Collider& body, int triangle) {
  const Triangle& t = body.surface->triangles[triangle];
  return {to_vec((*body.x)[t[0]]), to_vec((*body.x)[t[1]]), to_vec((*body.x)[t[2]])};
}

using Shares = std::array<double, 3>;  // barycentric

// How s comes out of t: by `depth` (m) along `way` (unit), where a point of each meets.
struct WayOut {
  Vec3 way;
  double depth = std::numeric_limits<double>::infinity();
  Shares of_s{}, of_t{};
};

int farthest(const Corners& t, const Vec3& along) {
  int best = 0;
  for (int k = 1; k < 3; ++k) {
    if (along.dot(t[k]) > along.dot(t[best])) best = k;
  }
  return best;
}

Shares at_corner(int k) {
  Shares shares{};
  shares[k] = 1.0;
  return shares;
}

Shares on_edge(int k, double along) {
  Shares shares{};
  shares[k] = 1.0 - along;
  shares[(k + 1) % 3] = along;
  return shares;
}

// Of the triangle's point below p, or of one near it where p is beside it.
Shares below(const Corners& t, const Vec3& p) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  Shares shares;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = t[(k + 1) % 3], &b = t[(k + 2) % 3];
    shares[k] = std::max((b - a).cross(p - a).dot(normal), 0.0);
    sum += shares[k];
  }
  for (double& share : shares) share = sum > 0.0 ? share / sum : 1.0 / 3.0;
  return shares;
}

// Along a normal of either, the farthest corner of the other out of its face.
WayOut out_of_face(const Corners& s, const Corners& t, const Vec3& way, bool face_is_t) {
  const int i = farthest(s, -way), j = farthest(t, way);
  return {way, way.dot(t[j] - s[i]), face_is_t ? at_corner(i) : below(s, t[j]),
          face_is_t ? below(t, s[i]) : at_corner(j)};
}

// The shortest of the ways along which two triangles come apart as convex bodies: a corner out of a
// face, or an edge over an edge (Ericson, Real-Time Collision Detection, 2005, 5.2.1). Only those
// that turn by 60 degrees at most from the way `out` of the surface of t.
WayOut shortest_way_out(const Corners& s, const Corners& t, const Vec3& out) {
  constexpr double kCone = 0.5;
  WayOut best;
  const auto toward_out = [&](const Vec3& axis) -> Vec3 {
    return axis.normalized() * (axis.dot(out) < 0.0 ? -1.0 : 1.0);
  };
  const auto take = [&](const WayOut& way) {
    if (way.way.dot(out) > kCone && way.depth < best.depth) best = way;
  };
  take(out_of_face(s, t, toward_out((t[1] - t[0]).cross(t[2] - t[0])), true));
  take(out_of_face(s, t, toward_out((s[1] - s[0]).cross(s[2] - s[0])), false));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3 u = s[(i + 1) % 3] - s[i], v = t[(j + 1) % 3] - t[j], between = t[j] - s[i];
      const Vec3 axis = u.cross(v);
      const double squared = axis.squaredNorm();
      if (!(squared > 1e-6 * u.squaredNorm() * v.squaredNorm())) continue;  // parallel
      const Vec3 way = toward_out(axis);
      if (way.dot(s[(i + 2) % 3] - s[i]) < 0.0 || way.dot(t[(j + 2) % 3] - t[j]) > 0.0) continue;
      take({way, way.dot(between),
            on_edge(i, std::clamp(between.cross(v).dot(axis) / squared, 0., 1.)),
            on_edge(j, std::clamp(between.cross(u).dot(axis) / squared, 0., 1.))});
    }
  }
  if (std::isinf(best.depth)) best = out_of_face(s, t, out, true);
  return best;
}

// Sum of the squares of the shares of corners that are free.
double free_squares(const Collider& body, int triangle, const Shares& shares) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (is_free(body, body.surface->triangles[triangle][k])) sum += shares[k] * shares[k];
  }
  return sum;
}

}  // namespace

void begin_parting(const Collider& body, Parting& parting) {
  const Surface& surface = *body.surface;
  const Points& x = *body.x;
  parting.push.assign(x.size(), Point{});
  parting.weight.assign(x.size(), 0.0);
  parting.normals.assign(x.size(), Point{});
  for (const Triangle& corners : surface.triangles) {
    const Vec3 u = to_vec(x[corners[1]] - x[corners[0]]), v = to_vec(x[corners[2]] - x[corners[0]]);
    const Point twice_area = to_point(u.cross(v));
    for (const int node : corners) parting.normals[node] += twice_area;
  }
  for (Point& normal : parting.normals) {
    const double length = norm(normal);
    if (length > 0.0) normal = normal * (1.0 / length);
  }
}

void find_partable(const Collider& a, const Collider& b, bool b_moves,
                   std::vector<std::array<int, 2>>& pairs) {
  find_crossings(*a.surface, *a.bvh, *a.x, *b.surface, *b.bvh, *b.x, pairs);
  std::erase_if(pairs, [&](const std::array<int, 2>& pair) {
    return !has_free_corner(a, pair[0]) && !(b_moves && has_free_corner(b, pair[1]));
  });
}

void push(const Collider& body, int node, double share, const Vec3& step, double longest,
          Parting& parting) {
  const double whole = step.norm(), length = std::min(share * whole, longest);
  if (!is_free(body, node) || !(length > 0.0)) return;
  parting.push[node] += to_point(length * length / whole * step);
  parting.weight[node] += length;
}

void push_apart(const Collider& a, Parting& of_a, const Collider& b, Parting* of_b,
                const std::vector<std::array<int, 2>>& pairs, double longest) {
  // A fifth more than what would touch: the corners that several pairs share go the mean of ways.
  constexpr double kBeyond = 1.2;
  // And more than what the rounding to single precision may take away.
  const auto rounding = [](const Corners& t) {
    return 4.0 * std::numeric_limits<float>::epsilon() * t[0].cwiseAbs().maxCoeff();
  };
  const auto normal_of = [](const Collider& body, const Parting* parting, int triangle) {
    if (parting == nullptr) return face_normal(*body.surface, *body.x, triangle);
    Point sum{};
    for (const int node : body.surface->triangles[triangle]) sum += parting->normals[node];
    return Vec3(to_vec(sum).normalized());
  };
  for (const auto& [ta, tb] : pairs) {
    const Vec3 out = steady_normal(normal_of(a, &of_a, ta), normal_of(b, of_b, tb));
    const Corners corners = corners_of(a, ta);
    const WayOut way = shortest_way_out(corners, corners_of(b, tb), out);
    double squares = free_squares(a, ta, way.of_s);
    if (of_b != nullptr) squares += free_squares(b, tb, way.of_t);
    if (!(squares > 0.0) || !(way.depth > 0.0)) continue;
    const Vec3 step = (kBeyond * way.depth + rounding(corners)) / squares * way.way;
    for (int k = 0; k < 3; ++k) {
      push(a, a.surface->triangles[ta][k], way.of_s[k], step, longest, of_a);
      if (of_b == nullptr) continue;
      push(b, b.surface->triangles[tb][k], way.of_t[k], -step, longest, *of_b);
    }
  }
}

void part(const Parting& parting, Points& x) {
  for (size_t i = 0; i < x.size(); ++i) {
    if (parting.weight[i] > 0.0) x[i] += parting.push[i] * (1.0 / parting.weight[i]);
  }
}

}  // namespace thew::skin
