// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/contact_memory.h"

#include <algorithm>
#include <limits>

#include "muscles/lengths.h"

namespace thew::skin {
namespace {

constexpr double kAnywhere = std::numeric_limits<double>::infinity();
constexpr double kEnough = 2.0;  // margins; what is so far apart need not be followed

}  // namespace

void Followed::go_on(const Points& now) {
  constexpr double kFar = 1e12;  // times rounding: anywhere, before the first search
  travelled_before = travelled;
  travelled += x.size() == now.size() ? largest_distance(now, x) : kFar * kRounding;
  before.swap(x);
  x = now;
}

Approach recall(const Collider& points_of, const Collider& surface, int points, double margin,
                ContactMemory::Other& known) {
  const Followed *a = points_of.followed, *b = surface.followed;
  const double travelled = a && b ? a->travelled + b->travelled : 0.0;
  Approach approach{a && b ? travelled - known.travelled + kRounding : kAnywhere, surface};
  if (a && b && a->parts.known && b->parts.known &&
      known.travelled == a->travelled_before + b->travelled_before) {
    approach.by_parts = true;
    find_motion_bounds(b->parts, a->parts, kEnough * margin, approach.motion_bound);
  }
  known.travelled = travelled;
  known.triangle.resize(points, -1);
  known.clear.resize(points, -kAnywhere);
  return approach;
}

double lowered(const Approach& approach, int part, double clear) {
  if (!(clear > 0.0) || !approach.by_parts) return clear - approach.owed;
  const MotionBound& motion_bound = approach.motion_bound[part];
  return std::min(clear - motion_bound.owed, motion_bound.apart);
}

void note_box(const Bvh& bvh, const Point& p, double& clear) {
  const double distance = box_distance(bvh, p);
  if (distance > 0.0) clear = std::max(clear, distance);
}

bool may_be_near(const Approach& approach, const Point& p, const Point& way, double margin,
                 double before, double& clear) {
  if (approach.surface.bvh->order.empty()) return false;
  if (before > 0.0 && approach.by_parts) {
    const MotionBound at =
        motion_bound(approach.surface.followed->parts, {p, p}, {way, way}, kEnough * margin);
    clear = std::max(clear, std::min(before - at.owed, at.apart));
  } else {
    note_box(*approach.surface.bvh, p, clear);
  }
  return clear < margin;
}

ClosestPoint look(const Collider& surface, const Vec3& p, double margin, double reach, int i,
                  ContactMemory::Other& known) {
  constexpr double kAhead = 3.0;  // margins, so that the next steps need not look
  double& clear = known.clear[i];
  // What may lie deeper than that is looked for anywhere, to learn its side.
  const double within =
      clear < -reach ? kAnywhere : std::min(reach, std::max(kAhead * margin, -clear));
  ClosestPoint found =
      closest_point(*surface.surface, *surface.bvh, *surface.x, p, within, known.triangle[i]);
  clear = found.triangle < 0 ? within : found.distance;
  if (found.triangle >= 0) known.triangle[i] = found.triangle;
  return found;
}

}  // namespace thew::skin
