// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/sweep.h"

#include <algorithm>
#include <cmath>

namespace thew::skin {
namespace {

// The box around a moved box; `farthest` is the longest motion of a corner (m).
NodeBox moved_box(const NodeBox& box, const Transform& motion, double& farthest) {
  NodeBox out = empty_box();
  farthest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1) ? box.high[k] : box.low[k];
    const Vec3 q = motion * p;
    farthest = std::max(farthest, (q - p).norm());
    grow(out, to_point(q), to_point(q));
  }
  return out;
}

// How much of the distance from `from` to `to` lies behind the point where it first enters the
// surface, by a march of steps no shorter than `least` (m). One that has bent over `from`, by
// `bent` (m) at most, has come that much farther.
double length_inside(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& from,
                     const Vec3& to, double least, double bent) {
  const double distance = (to - from).norm();
  if (bent > 0.0) {
    const ClosestPoint near = closest_point(surface, bvh, x, from, bent, -1);
    if (near.triangle >= 0 && near.distance <= 0.0) return distance - near.distance;
  }
  for (double gone = 0.0; gone < distance;) {
    const Vec3 p = from + gone / distance * (to - from);
    const ClosestPoint near = closest_point(surface, bvh, x, p, distance - gone, -1);
    if (near.triangle < 0) return 0.0;
    if (near.distance <= 0.0) return distance - gone;
    gone += std::max(near.distance, least);
  }
  return 0.0;
}

}  // namespace

BodyMotion body_motion(const Points& start, const Points& x) {
  return {box_of(start), box_of(x), largest_distance(x, start)};
}

bool may_tunnel(const BodyMotion& body, const Collider& rigid, double moved, double depth) {
  NodeBox both = body.after;
  grow(both, body.before.low, body.before.high);
  // During the step the bone was nowhere farther than this from its present position.
  if (!are_near(both, rigid.box, 2.0 * moved)) return false;
  // In the frame of the bone, whose motion moves the earlier position of the body.
  double farthest = 0.0;
  NodeBox swept = moved_box(body.before, rigid.from_start, farthest);
  grow(swept, body.after.low, body.after.high);
  return body.farthest + farthest + rigid.bent > depth && are_near(swept, rigid.box, rigid.bent);
}

Tunnelling find_tunnelling(const Points& start, const Points& x,
                           const std::vector<char>& free_nodes, const Collider& rigid, double depth,
                           double least) {
  Tunnelling worst;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!free_nodes[i]) continue;
    const Vec3 from = rigid.from_start * to_vec(start[i]), to = to_vec(x[i]);
    const double distance = (to - from).norm() + rigid.bent;
    if (distance <= depth) continue;
    double inside =
        length_inside(*rigid.surface, *rigid.bvh, *rigid.x, from, to, least, rigid.bent);
    // It may have bent past a node that lies as near as this.
    if (rigid.bent > depth &&
        closest_point(*rigid.surface, *rigid.bvh, *rigid.x, to, rigid.bent).triangle >= 0) {
      inside = std::max(inside, rigid.bent);
    }
    if (inside <= std::max(worst.inside, depth)) continue;
    worst = {static_cast<int>(i), inside, distance};
  }
  return worst;
}

}  // namespace thew::skin
