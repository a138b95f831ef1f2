// SPDX-License-Identifier: Apache-2.0
//
// Which vertices of a character's skin can be seen from outside, at rest and in a pose. A body of
// pieces or of layers has walls within: the end caps of its pieces, the balls of its joints, a body
// under its clothes.
#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "skin/depth.h"
#include "skin/skinned_skin.h"

namespace thew::skin {
namespace {

constexpr int kDirections = 128;    // over the sphere: 18 degrees apart
constexpr double kLeastRise = 0.1;  // of a direction over the tangent plane, sine of its angle

// Evenly over the sphere, on a spiral that turns by the golden angle from one to the next.
std::array<Vec3, kDirections> directions() {
  std::array<Vec3, kDirections> all;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  for (int k = 0; k < kDirections; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / kDirections, around = std::sqrt(1.0 - z * z);
    const auto [sine, cosine] = sin_cos(golden * k);
    all[k] = Vec3(around * cosine, around * sine, z);
  }
  return all;
}

bool meets_box(const Bvh::Node& node, const Vec3& p, const Vec3& inverse) {
  double from = 0.0, to = 1e300;
  for (int k = 0; k < 3; ++k) {
    const double a = (node.lo[k] - p[k]) * inverse[k], b = (node.hi[k] - p[k]) * inverse[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

// Whether the ray from p goes through the triangle (Moeller and Trumbore 1997).
bool meets_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p,
                    const Vec3& direction) {
  const Vec3 ab = b - a, ac = c - a, off = p - a, across = direction.cross(ac);
  const double det = ab.dot(across);
  if (det == 0.0) return false;
  const Vec3 turned = off.cross(ab);
  const double u = off.dot(across) / det, v = direction.dot(turned) / det;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(turned) / det > 0.0;
}

// Whether the ray from p meets the surface, triangles at the vertex itself aside.
bool is_met(const Surface& surface, const Bvh& bvh, const Points& x, int vertex, const Vec3& p,
            const Vec3& direction) {
  constexpr int kStack = 192;  // see kStack in bvh.cpp
  const Vec3 inverse = direction.cwiseInverse();
  int stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Node& node = bvh.nodes[stack[--top]];
    if (!meets_box(node, p, inverse)) continue;
    for (int i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = surface.triangles[bvh.order[i]];
      if (t[0] == vertex || t[1] == vertex || t[2] == vertex) continue;
      if (meets_triangle(to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]]), p, direction)) {
        return true;
      }
    }
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
  return false;
}

}  // namespace

void find_seen(SkinnedSkin& skin) {
  const std::array<Vec3, kDirections> all = directions();
  const Bvh bvh = build_bvh(skin.surface, skin.rest);
  skin.seen.assign(skin.rest.size(), 0);
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    const int v = static_cast<int>(i);
    if (skin.map_back[i] != v) continue;
    if (skin.surface.vertex_triangles[i].empty()) {
      skin.seen[i] = 1;
      continue;
    }
    const Vec3 p = to_vec(skin.rest[i]), normal = node_normal(skin.surface, skin.rest, v);
    skin.seen[i] = std::any_of(all.begin(), all.end(), [&](const Vec3& direction) {
      return normal.dot(direction) >= kLeastRise &&
             !is_met(skin.surface, bvh, skin.rest, v, p, direction);
    });
  }
}

std::vector<char> find_covered(const SkinnedSkin& skin, const std::vector<Collider>& muscles,
                               const Points& x, const Bvh& bvh) {
  std::vector<char> covered = skin.seen;
  for (const SkinnedSkin::Node& node : skin.nodes) {
    if (node.is_vertex() && !node.is_held) covered[node.corners[0]] = 0;
  }
  const auto is_among = [&](const Point& p) {
    return std::any_of(muscles.begin(), muscles.end(), [&](const Collider& muscle) {
      return !(box_distance(*muscle.bvh, p) > 0.0);
    });
  };
  for (size_t i = 0; i < covered.size(); ++i) {
    covered[i] = covered[i] && is_among(x[i]);
    if (!covered[i]) continue;
    const Vec3 normal = node_normal(skin.surface, x, static_cast<int>(i));
    const Vec3 over = to_vec(x[i]) + skin.settings.thickness * normal;
    covered[i] = encloses(skin.surface, bvh, x, over);
  }
  return covered;
}

}  // namespace thew::skin
