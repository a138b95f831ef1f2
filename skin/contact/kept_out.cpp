// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/kept_out.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::skin {
namespace {

// Lengths in m are those of a man. All were chosen by trial on characters in motion, the limits so
// that none is passed in the scenes of assets/arm.
constexpr double kLimit = 0.6e-3;         // deeper than at rest by less than this is left alone
constexpr double kFreeLimit = 1.5e-3;     // the same besides, of corners that contact moves
constexpr double kEndLimit = 2.5e-3;      // the same besides, where a tendon enters its bone:
constexpr double kEnd[] = {8e-3, 16e-3};  // so far from an end of the path it fades out
constexpr double kSpacing = 4e-3;         // of the samples of an edge
constexpr double kAhead = 20e-3;  // searched beyond what is asked, to spare the next searches
constexpr double kMost = 1e-3;    // that a node is moved: by 2 mm an edge to the belly did not hold
constexpr int kPasses = 3;        // of finding what is too deep and moving it
constexpr double kMostMoved = 2.5;  // [1], of a node, over its sample: others are left to contact

// A node, or a point of an edge.
struct Sample {
  std::array<int, 2> corners;
  std::array<double, 2> shares;  // [1], their sum is 1
  std::array<double, 2> moves;   // [1], of how far the sample is moved: 0 where a corner is free

  Point at(const Points& x) const { return shares[0] * x[corners[0]] + shares[1] * x[corners[1]]; }
};

// What is kept of the search of one bone, all in the frame of its body. It spares searches and does
// not change their results.
struct Kept {
  Points& samples;  // where each was searched for last, and its distance then at least, as a fourth
  Points& nodes;    // where they were when all samples were looked at, and then:
  double slack() const { return nodes.back()[3]; }  // m, the least of a sample beyond its limit
};

struct KeptOut {
  std::shared_ptr<const std::vector<RigidBone>> bones;
  std::vector<int> which;
  std::vector<int> nodes;  // those of the samples; what follows goes by them
  std::vector<Sample> samples;
  std::vector<std::vector<double>> limits;  // by bone and sample: m, the least distance
  double ahead = kAhead, most = kMost;      // m

  // `memory` has one entry for each bone's samples, then for each bone's nodes, then those of
  // Scratch.
  void push(const Pose& pose, Points& x, std::vector<Points>& memory) const;
};

// By node of the samples, kept so that a step does not allocate.
struct Scratch {
  static constexpr size_t kCount = 5;
  Points& before;     // m, what is carried
  Points& world;      // m
  Points& local;      // m, in the frame of a bone's body
  Points& pushes;     // m, the sum of all, and in the fourth coordinate of their lengths
  Points& strongest;  // m, the first coordinate alone
};

// Whether no sample can have passed its limit since all were looked at.
bool is_clear(const Points& now, const Kept& kept) {
  if (kept.nodes.empty()) return false;
  const double slack = kept.slack();
  if (!(slack > 0.0)) return false;
  for (size_t i = 0; i < now.size(); ++i) {
    const Point moved = now[i] - kept.nodes[i];
    if (dot(moved, moved) >= slack * slack) return false;
  }
  return true;
}

// Adds what a sample asks for, `by` (m), to its corners.
void add_push(const Sample& sample, const Vec3& by, double length, const Scratch& scratch) {
  for (int k = 0; k < 2; ++k) {
    if (sample.moves[k] == 0.0) continue;
    Point push = to_point(Vec3(sample.moves[k] * by));
    push[3] = sample.moves[k] * length;
    scratch.pushes[sample.corners[k]] += push;
    Point& strongest = scratch.strongest[sample.corners[k]];
    strongest[0] = std::max(strongest[0], push[3]);
  }
}

// Adds the pushes of one bone.
bool push_from(const RigidBone& bone, const std::vector<Sample>& samples,
               const std::vector<double>& limits, double ahead, const Transform& body,
               const Kept& kept, const Scratch& scratch) {
  if (is_clear(scratch.local, kept)) return false;
  if (kept.samples.empty()) kept.samples.resize(samples.size(), Point{0.0, 0.0, 0.0, -kAny});
  bool any = false;
  double slack = kAny;
  for (size_t s = 0; s < samples.size(); ++s) {
    const Point p = samples[s].at(scratch.local);
    Point& last = kept.samples[s];
    const double before = last[3], moved = to_vec(p - last).norm();
    double distance = before - moved;  // at least
    if (distance <= limits[s]) {
      const double at_most = before < 0.0 ? moved - before + kOnSurface : kAny;
      const double apart = box_distance(bone.bvh, p);
      ClosestPoint nearest;
      if (apart <= ahead) nearest = nearest_on(bone, to_vec(p), ahead, distance, at_most);
      distance = nearest.triangle < 0 ? std::max(apart, ahead) : nearest.distance;
      last = p;
      last[3] = distance;
      const double lack = limits[s] - distance;
      if (lack > 0.0) {
        add_push(samples[s], lack * (body.linear() * away_from(nearest, to_vec(p))), lack, scratch);
        any = true;
      }
    }
    slack = std::min(slack, distance - limits[s]);
  }
  kept.nodes = scratch.local;
  kept.nodes.push_back(Point{0.0, 0.0, 0.0, slack});
  return any;
}

void KeptOut::push(const Pose& pose, Points& x, std::vector<Points>& memory) const {
  const size_t count = which.size();
  memory.resize(2 * count + Scratch::kCount);
  const auto rest = memory.begin() + static_cast<std::ptrdiff_t>(2 * count);
  const Scratch scratch{rest[0], rest[1], rest[2], rest[3], rest[4]};
  scratch.world.resize(nodes.size());
  scratch.local.resize(nodes.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for (size_t i = 0; i < nodes.size(); ++i) scratch.world[i] = x[nodes[i]];
    scratch.pushes.assign(nodes.size(), Point{});
    scratch.strongest.assign(nodes.size(), Point{});
    const NodeBox box = box_of(scratch.world);
    const Vec3 middle = 0.5 * (to_vec(box.low) + to_vec(box.high));
    const double radius = (to_vec(box.high) - middle).norm();
    bool any = false;
    for (size_t b = 0; b < count; ++b) {
      const RigidBone& bone = (*bones)[which[b]];
      const Transform& body = pose[bone.body];
      const Mat3 turn = body.linear().transpose();
      const Vec3 by = -(turn * body.translation());
      if (box_distance(bone.bvh, to_point(Vec3(turn * middle + by))) > radius) continue;
      for (size_t i = 0; i < nodes.size(); ++i) {
        scratch.local[i] = to_point(Vec3(turn * to_vec(scratch.world[i]) + by));
      }
      const Kept kept{memory[b], memory[count + b]};
      any = push_from(bone, samples, limits[b], ahead, body, kept, scratch) || any;
    }
    if (!any) return;
    if (pass == 0) scratch.before = scratch.world;
    // As far as the strongest asks for, in their mean direction, and no farther than `most` in all.
    for (size_t i = 0; i < nodes.size(); ++i) {
      const Point& sum = scratch.pushes[i];
      if (!(sum[3] > 0.0)) continue;
      Point by = scratch.strongest[i][0] / sum[3] * sum;
      by[3] = 0.0;
      by += scratch.world[i] - scratch.before[i];
      const double far = norm(by);
      x[nodes[i]] = scratch.before[i] + (far > most ? most / far : 1.0) * by;
    }
  }
}

// The driven nodes, and points of the edges that hang on them.
std::vector<Sample> samples_of(const std::vector<Triangle>& triangles,
                               const std::vector<char>& driven, const Points& x, double spacing) {
  std::vector<Sample> samples;
  for (int i = 0; i < static_cast<int>(driven.size()); ++i) {
    if (driven[i]) samples.push_back({{i, i}, {1.0, 0.0}, {1.0, 0.0}});
  }
  const auto add = [&](int i, int j, double share) {
    Sample sample{{i, j}, {1.0 - share, share}, {}};
    double squares = 0.0;
    for (int k = 0; k < 2; ++k) sample.moves[k] = driven[sample.corners[k]] * sample.shares[k];
    for (const double moves : sample.moves) squares += moves * moves;
    if (std::max(sample.moves[0], sample.moves[1]) >= kMostMoved * squares) return;
    for (double& moves : sample.moves) moves /= squares;
    samples.push_back(sample);
  };
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      if (i > j || !(driven[i] || driven[j])) continue;  // the other triangle has it
      const int parts = static_cast<int>(std::ceil(norm(x[i] - x[j]) / spacing));
      for (int a = 1; a < parts; ++a) add(i, j, 1.0 * a / parts);
    }
  }
  return samples;
}

// Numbers the corners by themselves; their nodes.
std::vector<int> number_corners(size_t count, std::vector<Sample>& samples) {
  std::vector<int> nodes, number(count, -1);
  for (Sample& sample : samples) {
    for (int& corner : sample.corners) {
      if (number[corner] < 0) {
        number[corner] = static_cast<int>(nodes.size());
        nodes.push_back(corner);
      }
      corner = number[corner];
    }
  }
  return nodes;
}

}  // namespace

void keep_out(std::shared_ptr<const std::vector<RigidBone>> bones, std::vector<int> which,
              const std::vector<Triangle>& triangles, const std::vector<char>& driven,
              const Pose& rest_pose, double size, muscles::CarriedShape& shape) {
  Points rest;
  carried_positions(shape, muscles::carry_pose(shape, rest_pose), true, rest);
  auto kept = std::make_shared<KeptOut>();
  kept->samples = samples_of(triangles, driven, rest, kSpacing * size);
  kept->ahead = kAhead * size;
  kept->most = kMost * size;
  for (const int b : which) {
    const RigidBone& bone = (*bones)[b];
    const Transform to_body = rest_pose[bone.body].inverse();
    std::vector<double>& limits = kept->limits.emplace_back();
    for (const Sample& sample : kept->samples) {
      const ClosestPoint nearest = nearest_on(bone, to_body * to_vec(sample.at(rest)), 0.0);
      const double inside = nearest.triangle < 0 ? 0.0 : std::min(nearest.distance, 0.0);
      double along = 0.0, free = 0.0;
      for (int k = 0; k < 2; ++k) free += driven[sample.corners[k]] ? 0.0 : sample.shares[k];
      for (int k = 0; k < 2; ++k) along += sample.shares[k] * shape.along[sample.corners[k]];
      const double to_end = std::min(along, shape.rest_path_length - along);
      const double at_end = 1.0 - smoothstep(kEnd[0] * size, kEnd[1] * size, to_end);
      limits.push_back(inside - (kLimit + kEndLimit * at_end + kFreeLimit * free) * size);
    }
  }
  kept->nodes = number_corners(rest.size(), kept->samples);
  kept->which = std::move(which);
  kept->bones = std::move(bones);
  shape.clear_bones = [kept](const Pose& pose, Points& x, std::vector<Points>& memory) {
    kept->push(pose, x, memory);
  };
}

}  // namespace thew::skin
