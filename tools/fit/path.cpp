// SPDX-License-Identifier: Apache-2.0
//
// Paths across the joints of an arm that is not the template's.
#include <algorithm>

#include "tools/fit/arm.h"

namespace thew::tools {

void hold_at_elbow(const ArmFit& fit, const ArmBodies& arm, const Pose& rest,
                   const std::vector<double>& heights, MusclePath& path) {
  const Vec3 elbow = rest[arm.forearm].translation();
  const Vec3 down = (elbow - rest[arm.humerus].translation()).normalized();
  const double y = fit.elbow_template.y();
  for (size_t i = 0; i + 1 < path.points.size(); ++i) {
    const PathPoint a = path.points[i], b = path.points[i + 1];
    if (a.body != arm.humerus || (b.body != arm.ulna && b.body != arm.radius)) continue;
    const Vec3 from = rest[a.body] * a.position, way = rest[b.body] * b.position - from;
    const double above = down.dot(elbow - from), below = down.dot(way) - above;
    if (above <= 0.0 || below <= 0.0) return;
    const double upper = fit.girth.mean(heights[i], y), fore = fit.girth.mean(y, heights[i + 1]);
    const double near[] = {fit.across * upper * (heights[i] - y),
                           fit.across * std::min(upper, fore) * (y - heights[i + 1])};
    const int segment = static_cast<int>(i);
    const auto hold = [&](int body, double share) {
      const int first = body == arm.humerus ? segment : segment + 1;  // of the wraps that move on
      for (WrapCylinder& wrap : path.wraps) wrap.segment += wrap.segment >= first;
      const Vec3 held = from + share * way;
      path.points.insert(path.points.begin() + segment + 1, {body, rest[body].inverse() * held});
    };
    if (near[0] <= 0.0 || near[0] >= kSlender * above) return;
    if (near[1] > 0.0 && near[1] < kSlender * below) {
      hold(arm.ulna, (above + near[1]) / (above + below));
    }
    hold(arm.humerus, (above - near[0]) / (above + below));
    return;
  }
}

void hold_at_shoulder(const ArmBodies& arm, const Pose& rest, MusclePath& path) {
  // Of the humerus' turn against the blade. In ten random motions of the figure a share of 1 let
  // the biceps' short head 10.0 mm into the humerus, 0.85 and 0.7 by 4.4 and 3.7 mm; with 0.7 more
  // muscles lay in each other.
  constexpr double kShare = 0.85;
  // Of the humerus' length, the radius of its head with a tendon on it: points as near to the joint
  // lie on the head.
  constexpr double kHead = 0.14;
  const Vec3 joint = rest[arm.humerus].translation();
  const Vec3 way = rest[arm.forearm].translation() - joint, down = way.normalized();
  for (size_t i = 1; i + 1 < path.points.size(); ++i) {
    PathPoint& point = path.points[i];
    const Vec3 world = rest[point.body] * point.position;
    if (point.body != arm.scapula || down.dot(world - joint) <= 0.0) continue;
    point = {arm.humerus, rest[arm.humerus].inverse() * world};
    share_turn(arm.scapula, kShare, rest, point);
  }
  // A tendon slides over the head as that turns under it, so that the angle between its ends is
  // spread over its points there. Fixed to the head, the biceps' long head was drawn 6.9 mm into
  // the blade and 6.1 mm into the humerus in these motions; 4.9 and 3.9 mm with this.
  for (size_t i = 1, end = 1; i < path.points.size(); i = std::max(end, i + 1)) {
    const auto on_head = [&](const PathPoint& point) {
      return point.body == arm.humerus && point.with < 0 &&
             (rest[point.body] * point.position - joint).norm() < kHead * way.norm();
    };
    if (path.points[i - 1].body != arm.scapula) continue;
    for (end = i; end < path.points.size() && on_head(path.points[end]);) ++end;
    for (size_t k = i; k + 1 < end; ++k) {
      share_turn(arm.scapula, (k + 1.0 - i) / (end - i), rest, path.points[k]);
    }
  }
  // A path from the blade to the shaft would pass through the humerus' head or the blade's edge
  // when the arm is raised. A point near its beginning that takes a share of the turn keeps its
  // distance from the joint, whichever way the arm goes. Chosen by ten random motions of the
  // figure: with 0.25 and 0.55 of the turn the triceps' long head lies 8.5 and 8.2 mm in bone, 6.6
  // with 0.4. On wide shoulders too: in 24 random motions of MakeHuman it lay up to 11.5 mm in the
  // blade without it, and is the deepest muscle in none with more than 1.4 mm with it.
  // In front of the head, where the next point takes a share of the turn itself, one half way: with
  // an arm raised forwards or sideways the biceps' short head lay 4.0 mm in the figure's humerus,
  // and up to 7.0 in random motions; it is not the deepest in any of them with it. At 0.4 of the
  // way the coracobrachialis lies 2.3 mm in the blade in a walk.
  constexpr double kPart = 0.2, kPartInFront = 0.5, kHeldShare = 0.4;
  for (size_t i = 0; i + 1 < path.points.size(); ++i) {
    const PathPoint a = path.points[i], b = path.points[i + 1];
    if (a.body != arm.scapula || b.body != arm.humerus) continue;
    const double part = b.with < 0 ? kPart : kPartInFront;
    const Vec3 from = rest[a.body] * a.position, to = rest[b.body] * b.position;
    PathPoint held{arm.humerus, rest[arm.humerus].inverse() * (from + part * (to - from))};
    share_turn(arm.scapula, kHeldShare, rest, held);
    const int segment = static_cast<int>(i);
    for (WrapCylinder& wrap : path.wraps) wrap.segment += wrap.segment >= segment;
    path.points.insert(path.points.begin() + segment + 1, held);
    return;
  }
}

}  // namespace thew::tools
