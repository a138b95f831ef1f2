// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/sweep.h"

#include <algorithm>
#include <cmath>

namespace thew::skin {
namespace {

// The box of a box that has moved; `far`: the most that any of it did.
NodeBox moved_box(const NodeBox& box, const Transform& motion, double& far) {
  NodeBox out = empty_box();
  far = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1) ? box.high[k] : box.low[k];
    const Vec3 q = motion * p;
    far = std::max(far, (q - p).norm());
    grow(out, to_point(q), to_point(q));
  }
  return out;
}

// How much of the way from `from` to `to` lies behind the point where it first enters the surface,
// by a march of steps no shorter than `least` (m).
double way_inside(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& from,
                  const Vec3& to, double least) {
  const double way = (to - from).norm();
  for (double gone = 0.0; gone < way;) {
    const Vec3 p = from + gone / way * (to - from);
    const ClosestPoint near = closest_point(surface, bvh, x, p, way - gone, -1);
    if (near.triangle < 0) return 0.0;
    if (near.distance <= 0.0) return way - gone;
    gone += std::max(near.distance, least);
  }
  return 0.0;
}

}  // namespace

BodyWay way_of(const Points& start, const Points& x) {
  return {box_of(start), box_of(x), largest_distance(x, start)};
}

bool may_tunnel(const BodyWay& body, const Collider& rigid, double moved, double depth) {
  NodeBox both = body.after;
  grow(both, body.before.low, body.before.high);
  // Where the bone was, and its way between, lie this near to where it is.
  if (!are_near(both, rigid.box, 2.0 * moved)) return false;
  // As the bone sees it where it is now: before, the body was elsewhere.
  double far = 0.0;
  NodeBox swept = moved_box(body.before, rigid.forth, far);
  grow(swept, body.after.low, body.after.high);
  return body.farthest + far > depth && are_near(swept, rigid.box, 0.0);
}

Tunnelling find_tunnelling(const Points& start, const Points& x,
                           const std::vector<char>& free_nodes, const Collider& rigid, double depth,
                           double least) {
  Tunnelling worst;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!free_nodes[i]) continue;
    const Vec3 from = rigid.forth * to_vec(start[i]), to = to_vec(x[i]);
    const double way = (to - from).norm();
    if (way <= depth) continue;
    const double inside = way_inside(*rigid.surface, *rigid.bvh, *rigid.x, from, to, least);
    if (inside <= std::max(worst.inside, depth)) continue;
    worst = {static_cast<int>(i), inside, way};
  }
  return worst;
}

}  // namespace thew::skin
