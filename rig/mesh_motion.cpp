// SPDX-License-Identifier: Apache-2.0
#include "rig/mesh_motion.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cassert>

#include "rig/math.h"

namespace thew::rig {
namespace {

Vec3 centre_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(std::max<size_t>(points.size(), 1));
}

// The sample before a time, and the share of the way to the next.
struct Place {
  size_t sample;
  double share;
};
Place place_of(const std::vector<double>& times, double time) {
  const auto after =
      static_cast<size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (after == 0) return {0, 0.0};
  if (after == times.size()) return {after - 1, 0.0};
  return {after - 1, (time - times[after - 1]) / (times[after] - times[after - 1])};
}

}  // namespace

Transform nearest_motion(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  assert(from.size() == to.size());
  const Vec3 a = centre_of(from), b = centre_of(to);
  Mat3 sum = Mat3::Zero();
  for (size_t i = 0; i < from.size(); ++i) sum += (to[i] - b) * (from[i] - a).transpose();
  const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 signs = Vec3::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  Transform motion = Transform::Identity();
  motion.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  motion.translation() = b - motion.linear() * a;
  return motion;
}

MeshMotion motion_of(const std::vector<Vec3>& rest, const MeshSamples& samples, double begin) {
  MeshMotion motion;
  for (size_t k = 0; k < samples.times.size(); ++k) {
    const std::vector<Vec3>& now = samples.positions[k];
    motion.times.push_back(begin + samples.times[k]);
    motion.poses.push_back(nearest_motion(rest, now));
    const Transform back = motion.poses.back().inverse();
    Points& shape = motion.shapes.emplace_back();
    shape.reserve(now.size());
    for (size_t i = 0; i < now.size(); ++i) {
      const Vec3 p = back * now[i];
      const double bend = (p - rest[i]).norm();
      if (bend > motion.bend) motion.bend = bend, motion.bent_most = static_cast<int>(k);
      shape.push_back(to_point(p));
    }
  }
  if (motion.bend <= kRigid) motion.shapes.clear();
  return motion;
}

Transform between(const Transform& a, const Transform& b, double share) {
  constexpr double kFlat = 1e-7;  // sine of half the angle; a screw of less is a line to rounding
  if (share == 0.0) return a;
  if (share == 1.0) return b;
  const Transform way = a.inverse() * b;
  Eigen::Quaterniond turn(way.linear());
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  Transform part = Transform::Identity();
  const Vec3 axis = sine > 0.0 ? Vec3(turn.vec() / sine) : Vec3::UnitX();
  part.linear() = rotation_about(axis, share * 2.0 * arc_tan2(sine, turn.w()));
  if (sine < kFlat) {
    part.translation() = share * way.translation();
    return a * part;
  }
  const double along = axis.dot(way.translation());
  const Vec3 across = way.translation() - along * axis;
  // A point of the axis: c = 1/2 (t + cot(angle / 2) axis x t), for t across the axis.
  const Vec3 c = 0.5 * (across + turn.w() / sine * axis.cross(across));
  part.translation() = share * along * axis + (c - part.linear() * c);
  return a * part;
}

Transform pose_at(const MeshMotion& motion, double time) {
  const auto [k, share] = place_of(motion.times, time);
  return share > 0.0 ? between(motion.poses[k], motion.poses[k + 1], share) : motion.poses[k];
}

void shape_at(const MeshMotion& motion, double time, Points& x) {
  const auto [k, share] = place_of(motion.times, time);
  x = motion.shapes[k];
  if (!(share > 0.0)) return;
  const Points& next = motion.shapes[k + 1];
  for (size_t i = 0; i < x.size(); ++i) x[i] += share * (next[i] - x[i]);
}

}  // namespace thew::rig
