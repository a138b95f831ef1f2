// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/parting.h"

#include <algorithm>

#include "skin/contact/contact.h"

namespace thew::skin {
namespace {

bool is_free(const Collider& body, int node) {
  return body.free_nodes != nullptr && (*body.free_nodes)[node] != 0;
}

bool has_free_corner(const Collider& body, int triangle) {
  const Triangle& t = body.surface->triangles[triangle];
  return is_free(body, t[0]) || is_free(body, t[1]) || is_free(body, t[2]);
}

using Corners = std::array<Vec3, 3>;

Corners corners_of(const Collider& body, int triangle) {
  const Triangle& t = body.surface->triangles[triangle];
  return {to_vec((*body.x)[t[0]]), to_vec((*body.x)[t[1]]), to_vec((*body.x)[t[2]])};
}

// Heights (m) of s above the plane of t, whose unit normal is n.
std::array<double, 3> heights(const Corners& s, const Corners& t, const Vec3& n) {
  return {n.dot(s[0] - t[0]), n.dot(s[1] - t[0]), n.dot(s[2] - t[0])};
}

// Where a triangle that is cut by a plane, above which its corners have these heights, lies on the
// line of the cut: from, to.
std::array<double, 2> cut_of(const Corners& s, const std::array<double, 3>& height,
                             const Vec3& line) {
  std::array<double, 2> cut = {1e9, -1e9};
  for (int k = 0; k < 3; ++k) {
    const double a = height[k], b = height[(k + 1) % 3];
    if ((a < 0.0) == (b < 0.0)) continue;
    const double at = line.dot(s[k] + a / (a - b) * (s[(k + 1) % 3] - s[k]));
    cut = {std::min(cut[0], at), std::max(cut[1], at)};
  }
  return cut;
}

// m: what two triangles need to be parted, see push_apart().
double need_of(const Corners& s, const Corners& t) {
  const Vec3 ns = (s[1] - s[0]).cross(s[2] - s[0]).normalized();
  const Vec3 nt = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  const Vec3 line = ns.cross(nt).normalized();
  const std::array<double, 3> of_s = heights(s, t, nt), of_t = heights(t, s, ns);
  const std::array<double, 2> a = cut_of(s, of_s, line), b = cut_of(t, of_t, line);
  const double length = std::min(a[1], b[1]) - std::max(a[0], b[0]);
  const double depth = -std::min(*std::min_element(of_s.begin(), of_s.end()),
                                 *std::min_element(of_t.begin(), of_t.end()));
  return std::max(std::min(length, depth), 0.0);
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

void push_apart(const Collider& a, Parting& of_a, const Collider& b, Parting* of_b,
                const std::vector<std::array<int, 2>>& pairs, double longest) {
  const auto normal_of = [](const Collider& body, const Parting* parting, int triangle) {
    if (parting == nullptr) return face_normal(*body.surface, *body.x, triangle);
    Point sum{};
    for (const int node : body.surface->triangles[triangle]) sum += parting->normals[node];
    return Vec3(to_vec(sum).normalized());
  };
  const auto push = [](const Collider& body, int triangle, const Vec3& step, Parting& parting) {
    const double length = step.norm();
    for (const int node : body.surface->triangles[triangle]) {
      if (!is_free(body, node)) continue;
      parting.push[node] += to_point(length * step);
      parting.weight[node] += length;
    }
  };
  for (const auto& [ta, tb] : pairs) {
    const double need = std::min(2.0 * need_of(corners_of(a, ta), corners_of(b, tb)), longest);
    const Vec3 step = need * steady_normal(normal_of(a, &of_a, ta), normal_of(b, of_b, tb));
    push(a, ta, step, of_a);
    if (of_b != nullptr) push(b, tb, -step, *of_b);
  }
}

void part(const Parting& parting, Points& x) {
  for (size_t i = 0; i < x.size(); ++i) {
    if (parting.weight[i] > 0.0) x[i] += parting.push[i] * (1.0 / parting.weight[i]);
  }
}

}  // namespace thew::skin
