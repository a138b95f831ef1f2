// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/way_around.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::skin {
namespace {

// Lengths in m are those of a man. All were chosen by trial on characters in motion, the limits so
// that none is passed in the scenes of assets/arm, whose muscles contact alone keeps out of bone.
constexpr int kPasses = 6;  // of finding what is too near and moving it
// Nearer to a bone than at rest, and than the tendon is thick, by less than this is left alone.
constexpr double kLimit = 0.8e-3;
constexpr double kEndLimit = 1e-3;        // the same besides, where a tendon enters its bone:
constexpr double kEnd[] = {8e-3, 16e-3};  // so far from an end of the path it fades out
constexpr double kBellyLimit = 6e-3;      // the same besides, where it enters its belly:
constexpr double kFade = 30e-3;           // so far from it that fades out
// Contact moves bellies. So far inside of one, nothing is near enough any more.
constexpr double kInside = 5e-3, kLetBe = 0.05;
// What passes the limit is pushed beyond it, in the end to kLeft nearer than at rest: all of that
// way where it has passed the limit by kRise of it, so that it does not leap where it passes.
constexpr double kLeft = 5e-4, kRise = 1.5;
constexpr double kWidth = 4.0;  // of a push: the length to either side over which it fades out
// Of the distance from an end of the path: pushed no farther, so that no tendon leaves its bone
// with a kink.
constexpr double kSteepest = 0.8;
constexpr double kAhead = 5e-3;  // m, searched beyond what is asked, to spare the next searches

// By sample of the rest path, m: distances from a bone below which a point is pushed, and up to
// which; and the largest of the first.
struct Kept {
  std::vector<double> limits, clearances;
  double largest = 0.0;
};

// What the line of one muscle keeps free.
struct WayAround {
  std::shared_ptr<const std::vector<RigidBone>> bones;
  std::vector<int> which;
  double size = 1.0;  // of the body
  std::array<double, 2> belly;
  double rest_length = 0.0;  // m
  // By bone of `which`: what is kept free of it, an index. All that lie far off at rest share one.
  std::vector<int> kept_of;
  std::vector<Kept> kept;

  // Coordinate along the rest path of the sample at a share of the path's length, as a share.
  double at_rest(double share, double length) const {
    const double s = share * length, change = length - rest_length;
    if (s <= belly[0]) return s / rest_length;
    if (s >= belly[1] + change) return (s - change) / rest_length;
    const double now = belly[1] - belly[0] + change;
    return (belly[0] + (s - belly[0]) / now * (belly[1] - belly[0])) / rest_length;
  }
  // `memory` has one entry for each bone of `which`, then those of Scratch.
  bool push(const Pose& pose, double length, std::vector<Vec3>& points,
            std::vector<Points>& memory) const;
  bool find_pushes(const Pose& pose, double length, const std::vector<Vec3>& points, Points& pushes,
                   std::vector<Points>& memory) const;
  bool push_from(int b, const Transform& body, double length, const std::vector<Vec3>& points,
                 Points& pushes, Points& memory) const;
};

double interpolate(const std::vector<double>& values, double share) {
  const int last = static_cast<int>(values.size()) - 1;
  const double at = std::clamp(share, 0.0, 1.0) * last;
  const int i = std::min(static_cast<int>(at), last - 1);
  return values[i] + (at - i) * (values[i + 1] - values[i]);
}

// Adds the pushes of one bone. `memory` has for each point where, in the frame of the body, it was
// searched for last, and in the fourth coordinate what its distance (m) was then at least: as far
// as it has moved since, so much nearer it may be.
bool WayAround::push_from(int b, const Transform& body, double length,
                          const std::vector<Vec3>& points, Points& pushes, Points& memory) const {
  const RigidBone& bone = (*bones)[which[b]];
  const Kept& keep = kept[kept_of[b]];
  const Transform to_body = body.inverse();
  const int last = static_cast<int>(points.size()) - 1;
  memory.resize(points.size(), Point{0.0, 0.0, 0.0, -kAny});
  bool any = false;
  for (int i = 1; i < last; ++i) {
    const double at = at_rest(static_cast<double>(i) / last, length);
    const double limit = interpolate(keep.limits, at);
    const Vec3 p = to_body * points[i];
    const double before = memory[i][3], moved = (p - to_vec(memory[i])).norm();
    if (before - moved > limit) continue;
    const double within = std::max(limit, 0.0) + kAhead * size;
    const double at_most = before < 0.0 ? moved - before + kOnSurface : kAny;
    const ClosestPoint nearest = nearest_on(bone, p, within, before - moved, at_most);
    const double distance = nearest.triangle < 0 ? within : nearest.distance;
    memory[i] = to_point(p);
    memory[i][3] = distance;
    if (distance >= limit) continue;
    const double beyond = interpolate(keep.clearances, at) - limit;
    const double wanted = limit + beyond * smoothstep(0.0, kRise * beyond, limit - distance);
    const double most = kSteepest * length * std::min(i, last - i) / last;
    const Vec3 away = body.linear() * away_from(nearest, p);
    pushes[i] += to_point(Vec3(std::min(wanted - distance, most) * away));
    any = true;
  }
  return any;
}

bool WayAround::find_pushes(const Pose& pose, double length, const std::vector<Vec3>& points,
                            Points& pushes, std::vector<Points>& memory) const {
  pushes.assign(points.size(), Point{});
  NodeBox box = empty_box();
  for (const Vec3& p : points) grow(box, to_point(p), to_point(p));
  const Vec3 middle = 0.5 * (to_vec(box.low) + to_vec(box.high));
  const double radius = (to_vec(box.high) - middle).norm();
  bool any = false;
  for (size_t b = 0; b < which.size(); ++b) {
    const RigidBone& bone = (*bones)[which[b]];
    const Transform& body = pose[bone.body];
    const Point centre = to_point(Vec3(body.inverse() * middle));
    if (!are_near(bone.box, {centre, centre}, radius + std::max(kept[kept_of[b]].largest, 0.0)))
      continue;
    any = push_from(static_cast<int>(b), body, length, points, pushes, memory[b]) || any;
  }
  return any;
}

// By point, kept so that a step does not allocate.
struct Scratch {
  static constexpr size_t kCount = 3;
  Points& pushes;  // m
  Points& sums;  // of the pushes of a neighbourhood, and in the fourth coordinate of their weights
  Points& strongest;  // m, the first coordinate alone
};

// Moves each point by the pushes of its neighbourhood: as far as the strongest asks for, weighted
// by how near it is, in their mean direction.
void move_all(const Scratch& scratch, double spacing, std::vector<Vec3>& points) {
  auto& [pushes, sums, strongest] = scratch;
  const int last = static_cast<int>(points.size()) - 1;
  sums.assign(points.size(), Point{});
  strongest.assign(points.size(), Point{});
  for (int k = 1; k < last; ++k) {
    const double push = to_vec(pushes[k]).norm();
    if (push == 0.0) continue;
    const double reach = 2.0 + kWidth * push / spacing;  // samples
    for (const int side : {-1, 1}) {
      const double width = std::min(reach, static_cast<double>(side < 0 ? k : last - k));
      for (int i = side < 0 ? k : k + 1; std::abs(i - k) < width; i += side) {
        const double weight = 1.0 - smoothstep(0.0, width, std::abs(i - k));
        sums[i] += weight * pushes[k];
        sums[i][3] += weight * push;
        strongest[i][0] = std::max(strongest[i][0], weight * push);
      }
    }
  }
  for (int i = 1; i < last; ++i) {
    if (sums[i][3] > 0.0) points[i] += strongest[i][0] / sums[i][3] * to_vec(sums[i]);
  }
}

bool WayAround::push(const Pose& pose, double length, std::vector<Vec3>& points,
                     std::vector<Points>& memory) const {
  const size_t count = which.size();
  memory.resize(count + Scratch::kCount);
  const Scratch scratch{memory[count], memory[count + 1], memory[count + 2]};
  const double spacing = length / static_cast<double>(points.size() - 1);
  int pass = 0;
  while (pass < kPasses && find_pushes(pose, length, points, scratch.pushes, memory)) {
    move_all(scratch, spacing, points);
    ++pass;
  }
  return pass > 0;
}

// The mean distance (m) of the nodes from the curve, about each sample of the rest path.
std::vector<double> radii_of(const CarriedShape& shape, int count) {
  std::vector<double> sum(count, 0.0), nodes(count, 0.0), radii(count, 0.0);
  for (size_t i = 0; i < shape.along.size(); ++i) {
    const double at = shape.along[i] / shape.rest_path_length * (count - 1);
    const int k = std::clamp(static_cast<int>(std::lround(at)), 0, count - 1);
    sum[k] += std::sqrt(shape.offset[i].tail<2>().squaredNorm());
    nodes[k] += 1.0;
  }
  for (int k = 0; k < count; ++k) {
    double near_sum = 0.0, near_nodes = 0.0;
    for (int width = 2; near_nodes == 0.0 && width < 2 * count; width *= 2) {
      for (int j = std::max(k - width, 0); j <= std::min(k + width, count - 1); ++j) {
        near_sum += sum[j];
        near_nodes += nodes[j];
      }
    }
    radii[k] = near_nodes > 0.0 ? near_sum / near_nodes : 0.0;
  }
  return radii;
}

// The distances (m) of the samples of the curve at rest from the bone, where they are less than
// the radii there; else these.
bool find_rest_distances(const RigidBone& bone, const Transform& to_body,
                         const muscles::CarryCurve& curve, const std::vector<double>& radii,
                         std::vector<double>& distances) {
  bool any = false;
  distances = radii;
  for (size_t i = 0; i < radii.size(); ++i) {
    const Vec3 p = to_body * to_vec(curve.samples[i].point);
    const ClosestPoint nearest = nearest_on(bone, p, radii[i]);
    if (nearest.triangle < 0 || nearest.distance >= radii[i]) continue;
    distances[i] = nearest.distance;
    any = true;
  }
  return any;
}

Kept kept_from(const CarriedShape& shape, double size, const std::vector<double>& at_rest) {
  Kept keep;
  const int count = static_cast<int>(at_rest.size());
  for (int i = 0; i < count; ++i) {
    const double s = shape.rest_path_length * i / (count - 1);
    const double before = shape.belly[0] - s, beyond = s - shape.belly[1];  // the belly
    const double at_belly = 1.0 - smoothstep(0.0, kFade * size, std::max(before, beyond));
    const double inside = smoothstep(0.0, kInside * size, -std::max(before, beyond));
    const double to_end = std::min(s, shape.rest_path_length - s);
    const double at_end = 1.0 - smoothstep(kEnd[0] * size, kEnd[1] * size, to_end);
    const double slack =
        kLimit + kEndLimit * at_end + kBellyLimit * at_belly + kLetBe * inside;  // m, of a man
    keep.limits.push_back(at_rest[i] - slack * size);
    keep.clearances.push_back(at_rest[i] - kLeft * size);
  }
  keep.largest = *std::max_element(keep.limits.begin(), keep.limits.end());
  return keep;
}

}  // namespace

void pass_around(std::shared_ptr<const std::vector<RigidBone>> bones, std::vector<int> which,
                 const Pose& rest_pose, double size, CarriedShape& shape) {
  const muscles::CarriedPose rest = muscles::carry_pose(shape, rest_pose);
  auto way = std::make_shared<WayAround>();
  way->size = size;
  way->belly = shape.belly;
  way->rest_length = shape.rest_path_length;
  const std::vector<double> radii = radii_of(shape, static_cast<int>(rest.curve.samples.size()));
  way->kept.push_back(kept_from(shape, size, radii));
  std::vector<double> at_rest;
  for (const int b : which) {
    const RigidBone& bone = (*bones)[b];
    way->kept_of.push_back(0);
    if (!find_rest_distances(bone, rest_pose[bone.body].inverse(), rest.curve, radii, at_rest))
      continue;
    way->kept_of.back() = static_cast<int>(way->kept.size());
    way->kept.push_back(kept_from(shape, size, at_rest));
  }
  way->which = std::move(which);
  way->bones = std::move(bones);
  shape.give_way = [way](const Pose& pose, double length, std::vector<Vec3>& points,
                         std::vector<Points>& memory) {
    return way->push(pose, length, points, memory);
  };
}

}  // namespace thew::skin
