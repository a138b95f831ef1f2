// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/rigid_bone.h"

#include <algorithm>
#include <cmath>

namespace thew::skin {

RigidBone rigid_bone(int body, Surface surface, Points x) {
  RigidBone bone{body, std::move(surface), std::move(x), {}, {}};
  bone.bvh = build_bvh(bone.surface, bone.x);
  bone.box = box_of(bone.x);
  return bone;
}

ClosestPoint nearest_on(const RigidBone& bone, const Vec3& p, double within, double at_least,
                        double at_most) {
  const NodeBox at{to_point(p), to_point(p)};
  if (!are_near(bone.box, at, within)) return {};
  const bool outside = at_least > 0.0 || !are_near(bone.box, at, 0.0);
  const double bound = outside ? within : std::max(within, at_most);
  return closest_point(bone.surface, bone.bvh, bone.x, p, bound);
}

Vec3 away_from(const ClosestPoint& nearest, const Vec3& p) {
  const bool on_it = std::abs(nearest.distance) < kOnSurface;
  return on_it ? nearest.normal : Vec3((p - nearest.point) / nearest.distance);
}

}  // namespace thew::skin
