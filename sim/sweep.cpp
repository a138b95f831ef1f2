// SPDX-License-Identifier: Apache-2.0
#include "sim/sweep.h"

#include <algorithm>
#include <cmath>

#include "sim/drive.h"

namespace thew {
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
    grow(out, to_row(q), to_row(q));
  }
  return out;
}

// How much of the way from `from` to `to` lies behind the point where it first enters the surface,
// by a march of steps no shorter than `least` (m).
double way_inside(const Surface& surface, const Bvh& bvh, const Rows& x, const Vec3& from,
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

std::optional<Trouble> find_leap(const Model& model, State& state) {
  if (!model.contact.enabled || state.pose_before.size() != state.pose.size()) return {};
  const double depth = model.contact.settings.max_depth;
  std::optional<Trouble> worst;
  std::vector<NodeBox> boxes;
  for (const BoneState& bone : state.bones) boxes.push_back(box_of(bone.x));
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    if (!has_forces(now.level)) continue;
    const NodeBox before = box_of(now.start), after = box_of(now.x);
    NodeBox both = after;
    grow(both, before.low, before.high);
    const double own = largest_distance(now.x, now.start);
    for (size_t b = 0; b < model.bones.size(); ++b) {
      const Bone& bone = model.bones[b];
      const Surface& surface = model.surfaces[state.muscles.size() + b].surface;
      if (model.ignore[m][state.muscles.size() + b]) continue;
      // Where the bone was, and its way between, lie this near to where it is.
      if (!are_near(both, boxes[b], 2.0 * state.bones[b].moved)) continue;
      // As the bone sees it where it is now: before, the muscle was elsewhere.
      const Transform since = state.pose[bone.body] * state.pose_before[bone.body].inverse();
      double far = 0.0;
      NodeBox swept = moved_box(before, since, far);
      grow(swept, after.low, after.high);
      if (own + far <= depth || !are_near(swept, boxes[b], 0.0)) continue;
      fit_bone(model, static_cast<int>(b), state);
      for (size_t i = 0; i < now.x.size(); ++i) {
        if (!model.muscles[m].free_nodes[i]) continue;
        const Vec3 from = since * to_vec(now.start[i]), to = to_vec(now.x[i]);
        if ((to - from).norm() <= depth) continue;
        const double inside = way_inside(surface, state.bones[b].bvh, state.bones[b].x, from, to,
                                         model.lengths.march);
        if (inside <= (worst ? worst->value : depth)) continue;
        worst = Trouble{"muscle \"" + model.muscles[m].name + "\"",
                        static_cast<int>(i),
                        "way into a bone in one step",
                        inside,
                        depth,
                        "m"};
        worst->parts = static_cast<int>(std::ceil(std::min((to - from).norm() / depth, 1e6)));
      }
    }
  }
  return worst;
}

}  // namespace thew
