// SPDX-License-Identifier: Apache-2.0
//
// Paths across the joints of an arm that is not the template's.
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
    const double near = fit.across * fit.girth.mean(heights[i], y) * (heights[i] - y);
    if (near <= 0.0 || near >= kSlender * above) return;
    const Vec3 held = from + (above - near) / (above + below) * way;
    const int segment = static_cast<int>(i);
    for (WrapCylinder& wrap : path.wraps) wrap.segment += wrap.segment >= segment;
    path.points.insert(path.points.begin() + segment + 1, {a.body, rest[a.body].inverse() * held});
    return;
  }
}

void hold_at_shoulder(const ArmBodies& arm, const Pose& rest, MusclePath& path) {
  // Of the humerus' turn against the body that stands for the blade: a living one turns by a third
  // of the arm's elevation, and what lies on it glides. With all of the turn the path from the
  // coracoid folds back on itself when the arm drops; with half of it muscles overlap.
  constexpr double kShare = 0.7;
  const Vec3 joint = rest[arm.humerus].translation();
  const Vec3 down = (rest[arm.forearm].translation() - joint).normalized();
  for (size_t i = 1; i + 1 < path.points.size(); ++i) {
    PathPoint& point = path.points[i];
    const Vec3 world = rest[point.body] * point.position;
    if (point.body != arm.clavicle || down.dot(world - joint) <= 0.0) continue;
    point = {arm.humerus, rest[arm.humerus].inverse() * world};
    share_turn(arm.clavicle, kShare, rest, point);
  }
  // A path that leaves the blade beside the joint for a place far down the shaft would pass through
  // the humerus' head when the arm is raised. A point near its beginning that takes a share of the
  // turn keeps its distance from the joint. Chosen by ten random motions of the figure: the
  // triceps' long head 13.0 mm in the humerus without it, 8.7 with 0.3 and 0.5, 6.9 with these.
  constexpr double kFar = 2.0;  // times as far from the joint as where it leaves the blade
  constexpr double kPart = 0.2, kHeldShare = 0.4;
  for (size_t i = 0; i + 1 < path.points.size(); ++i) {
    const PathPoint a = path.points[i], b = path.points[i + 1];
    if (a.body != arm.clavicle || b.body != arm.humerus || b.with >= 0) continue;
    const Vec3 from = rest[a.body] * a.position, to = rest[b.body] * b.position;
    if ((to - joint).norm() < kFar * (from - joint).norm()) return;
    PathPoint held{arm.humerus, rest[arm.humerus].inverse() * (from + kPart * (to - from))};
    share_turn(arm.clavicle, kHeldShare, rest, held);
    const int segment = static_cast<int>(i);
    for (WrapCylinder& wrap : path.wraps) wrap.segment += wrap.segment >= segment;
    path.points.insert(path.points.begin() + segment + 1, held);
    return;
  }
}

}  // namespace thew::tools
