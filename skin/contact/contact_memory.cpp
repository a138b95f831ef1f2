// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/contact_memory.h"

#include <algorithm>
#include <limits>

#include "muscles/lengths.h"

namespace thew::skin {
namespace {

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
// In margins: parts that stay farther apart need no motion bound; chosen by trial.
constexpr double kFarMargins = 2.0;

}  // namespace

void MotionHistory::advance(const Points& now) {
  constexpr double kFar = 1e12;  // times kRounding: as good as unbounded, before the first search
  travelled_before = travelled;
  travelled += x.size() == now.size() ? largest_distance(now, x) : kFar * kRounding;
  before.swap(x);
  x = now;
}

Approach recall(const Collider& points_of, const Collider& surface, int points, double margin,
                ContactMemory::Other& known) {
  const MotionHistory *a = points_of.history, *b = surface.history;
  const double travelled = a && b ? a->travelled + b->travelled : 0.0;
  Approach approach{a && b ? travelled - known.travelled + kRounding : kUnbounded, surface};
  if (a && b && a->parts.known && b->parts.known &&
      known.travelled == a->travelled_before + b->travelled_before) {
    approach.by_parts = true;
    find_motion_bounds(b->parts, a->parts, kFarMargins * margin, approach.motion_bound);
  }
  known.travelled = travelled;
  known.triangle.resize(points, -1);
  known.distance_bound.resize(points, -kUnbounded);
  return approach;
}

namespace {

double lowered(double bound, const MotionBound& by) {
  return std::min(bound - by.approach, by.separation);
}

// Of the points of all parts.
MotionBound worst_of(const Approach& approach) {
  MotionBound worst{approach.distance, kUnbounded};
  if (!approach.by_parts) return worst;
  worst.approach = 0.0;
  for (const MotionBound& of_part : approach.motion_bound) {
    worst.approach = std::max(worst.approach, of_part.approach);
    if (of_part.separation > 0.0) worst.separation = std::min(worst.separation, of_part.separation);
  }
  return worst;
}

}  // namespace

void lower_bounds(const Approach& approach, const std::vector<int>& part, double margin,
                  const std::vector<char>* searched, ContactMemory::Other& known,
                  ContactMemory& memory) {
  const int points = static_cast<int>(known.distance_bound.size());
  memory.nearing_count = 0;
  const MotionBound worst = worst_of(approach);
  if (lowered(known.least, worst) >= margin) {
    known.least = lowered(known.least, worst);
    known.pending = {known.pending.approach + worst.approach,
                     lowered(known.pending.separation, worst)};
    return;
  }
  if (static_cast<int>(memory.nearing.size()) < points) memory.nearing.resize(points);
  double* const bounds = known.distance_bound.data();
  ContactMemory::Nearing* const nearing = memory.nearing.data();
  int count = 0;
  double least = kUnbounded;
  for (int i = 0; i < points; ++i) {
    const double before = lowered(bounds[i], known.pending);
    double bound = before - approach.distance;
    if (approach.by_parts) {
      const double outside = lowered(before, approach.motion_bound[part[i]]);
      bound = before > 0.0 ? outside : bound;
    }
    bounds[i] = bound;
    const bool counts = !searched || (*searched)[i];
    least = counts ? std::min(least, bound) : least;
    nearing[count] = {i, before};
    count += counts && bound < margin;
  }
  memory.nearing_count = count;
  known.least = least;
  known.pending = {0.0, kUnbounded};
}

void raise_by_box(const Bvh& bvh, const Point& p, double& bound) {
  const double distance = box_distance(bvh, p);
  if (distance > 0.0) bound = std::max(bound, distance);
}

bool may_be_within(const Approach& approach, const Point& p, const Point& motion, double margin,
                   double before, double& bound) {
  if (approach.surface.bvh->order.empty()) return false;
  if (before > 0.0 && approach.by_parts) {
    const MotionBound at = motion_bound(approach.surface.history->parts, {p, p}, {motion, motion},
                                        kFarMargins * margin);
    bound = std::max(bound, std::min(before - at.approach, at.separation));
  } else {
    raise_by_box(*approach.surface.bvh, p, bound);
  }
  return bound < margin;
}

ClosestPoint find_closest(const Collider& surface, const Vec3& p, double margin, double reach,
                          int i, ContactMemory::Other& known) {
  // In margins: a larger search, so that the next steps need none; chosen by trial.
  constexpr double kAheadMargins = 3.0;
  double& bound = known.distance_bound[i];
  // A point that may be deeper than `reach` is searched for without a bound, to find its side.
  const double radius =
      bound < -reach ? kUnbounded : std::min(reach, std::max(kAheadMargins * margin, -bound));
  ClosestPoint found =
      closest_point(*surface.surface, *surface.bvh, *surface.x, p, radius, known.triangle[i]);
  bound = found.triangle < 0 ? radius : found.distance;
  if (found.triangle >= 0) known.triangle[i] = found.triangle;
  return found;
}

}  // namespace thew::skin
