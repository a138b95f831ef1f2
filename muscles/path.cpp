// SPDX-License-Identifier: Apache-2.0
#include "muscles/path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "rig/math.h"

namespace thew::muscles {
namespace {

// The frame of a cylinder in the world. Columns 0 and 1 span its section, column 2 is its axis. For
// turn = -1 column 1 is mirrored, so that the path always goes around counter-clockwise.
struct Section {
  Mat3 axes;
  Vec3 centre;
  double radius;
};

Section section_of(const WrapCylinder& wrap, const Transform& body) {
  const Vec3 axis = wrap.axis.normalized();
  const Vec3 across = axis.unitOrthogonal();
  Mat3 axes;
  axes << across, wrap.turn * axis.cross(across), axis;
  return {body.linear() * axes, body * wrap.centre, wrap.radius};
}

double cross(const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); }
double dot(const Vec3& a, const Vec3& b) { return a.x() * b.x() + a.y() * b.y(); }

// An end of the segment in the frame of the section. A point inside the cylinder is moved to its
// surface.
struct End {
  Vec3 p;              // x, y in the section, z along the axis
  double tangent = 0;  // m, length of the tangent from the point to the circle
};

End end_of(const Section& section, const Vec3& world) {
  End end{section.axes.transpose() * (world - section.centre)};
  const double distance = std::sqrt(dot(end.p, end.p));
  if (distance > section.radius) {
    end.tangent = std::sqrt((distance - section.radius) * (distance + section.radius));
  } else {
    const Vec3 outward = distance > 0.0 ? Vec3(end.p / distance) : Vec3(Vec3::UnitX());
    end.p.head<2>() = section.radius * outward.head<2>();
  }
  return end;
}

// Share (0..1) of the straight segment in the path; the remainder is the arc. It is 1 where the
// segment keeps the centre at a radius or more on its left, or the centre lies beyond one of its
// ends. It is 0 where the segment cuts the circle on that side. On the wrong side it rises from 0
// to 1 as the angle at an end, between segment and centre, goes from 60 to 90 degrees.
double straight_share(double radius, const End& a, const End& b) {
  constexpr double kLeavesFrom = 0.5;  // cosine of 60 degrees
  const Vec3 along = b.p - a.p;
  const double length = std::sqrt(dot(along, along)), turn = cross(a.p, b.p);
  const double ahead = -dot(a.p, along), behind = dot(b.p, along);
  if (ahead <= 0.0 || behind <= 0.0 || turn >= radius * length) return 1.0;
  if (turn >= 0.0) return 0.0;
  const double cosine =
      std::min(ahead / std::sqrt(dot(a.p, a.p)), behind / std::sqrt(dot(b.p, b.p))) / length;
  return 1.0 - smoothstep(0.0, kLeavesFrom, cosine);
}

// Angle (rad) over which the shortest path on the given side lies on the cylinder.
double wrap_angle(double radius, const End& a, const End& b) {
  double between = arc_tan2(cross(a.p, b.p), dot(a.p, b.p));
  if (between < 0.0) between += 2.0 * kPi;
  return std::max(between - arc_tan2(a.tangent, radius) - arc_tan2(b.tangent, radius), 0.0);
}

// The point where a tangent from `end` touches the circle, in the sense of the path (side 1) or
// against it (-1).
Vec3 touch_point(double radius, const End& end, double side) {
  const double d2 = dot(end.p, end.p);
  const double c = radius / d2 * radius, s = side * radius / d2 * end.tangent;
  return {c * end.p.x() - s * end.p.y(), c * end.p.y() + s * end.p.x(), 0.0};
}

// Appends kArcPoints points and returns the length from a to b (m).
double trace_wrap(const Section& section, const Vec3& from, const Vec3& to,
                  std::vector<Vec3>& points) {
  const End a = end_of(section, from), b = end_of(section, to);
  const auto emit = [&](const Vec3& p) { points.push_back(section.centre + section.axes * p); };
  const double straight = straight_share(section.radius, a, b);
  const Vec3 along = b.p - a.p;
  const double length2 = dot(along, along);
  const double t = length2 > 0.0 ? std::clamp(-dot(a.p, along) / length2, 0.0, 1.0) : 0.0;
  const Vec3 nearest = a.p + t * along;
  if (straight >= 1.0) {
    for (int i = 0; i < kArcPoints; ++i) emit(nearest);
    return along.norm();
  }
  const double angle = wrap_angle(section.radius, a, b);
  // An unrolled helix is a straight line, so z is linear in the length covered in the section.
  const double flat = a.tangent + section.radius * angle + b.tangent;
  const double slope = flat > 0.0 ? (b.p.z() - a.p.z()) / flat : 0.0;
  const Vec3 touch = touch_point(section.radius, a, 1.0);
  for (int i = 0; i < kArcPoints; ++i) {
    const double turned = angle * i / (kArcPoints - 1);
    const auto [s, c] = sin_cos(turned);
    const Vec3 round(c * touch.x() - s * touch.y(), s * touch.x() + c * touch.y(),
                     a.p.z() + slope * (a.tangent + section.radius * turned));
    emit(straight > 0.0 ? Vec3(round + straight * (nearest - round)) : round);
  }
  const double round = flat * std::sqrt(1.0 + slope * slope);
  return straight > 0.0 ? round + straight * (along.norm() - round) : round;
}

// The wrap of a segment, null where there is none.
const WrapCylinder* wrap_of(const MusclePath& path, int segment) {
  const auto is_of = [&](const WrapCylinder& wrap) { return wrap.segment == segment; };
  const auto found = std::find_if(path.wraps.begin(), path.wraps.end(), is_of);
  return found == path.wraps.end() ? nullptr : &*found;
}

void check_path(const MusclePath& path) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::kUsage, "muscle path: " + what);
  };
  if (path.points.size() < 2) refuse("it lacks an origin or an insertion; add path points");
  const int segments = static_cast<int>(path.points.size()) - 1;
  for (const WrapCylinder& wrap : path.wraps) {
    const auto segment = [&] { return "segment " + std::to_string(wrap.segment); };
    if (wrap.segment < 0 || wrap.segment >= segments) {
      refuse(segment() + " has a wrap but does not exist; count segments from 0 at the origin");
    }
    if (wrap_of(path, wrap.segment) != &wrap) {
      refuse(segment() + " has two wraps; put a path point between them");
    }
  }
}

// A share of a rotation, about the same axis.
Mat3 share_of_turn(const Mat3& turn, double share) {
  constexpr double kRisesFrom = 120.0 * kDegree;
  Eigen::Quaterniond q(turn);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return Mat3::Identity();
  const double angle = 2.0 * arc_tan2(sine, q.w());
  const double part = share + (1.0 - share) * smoothstep(kRisesFrom, kPi, angle);
  return rotation_about(q.vec() / sine, part * angle);
}

}  // namespace

void share_turn(int with, double share, const Pose& rest_pose, PathPoint& point) {
  point.with = with;
  point.share = share;
  point.rest_rotation = rest_pose[with].linear().transpose() * rest_pose[point.body].linear();
}

Transform frame_of_point(const PathPoint& point, const Pose& pose) {
  if (point.with < 0) return pose[point.body];
  Transform frame = pose[point.body];
  const Mat3 with = pose[point.with].linear();
  const Mat3 turn = with.transpose() * frame.linear() * point.rest_rotation.transpose();
  frame.linear() = with * share_of_turn(turn, point.share) * point.rest_rotation;
  return frame;
}

TracedPath trace_path(const MusclePath& path, const Pose& pose) {
  TracedPath traced;
  trace_path(path, pose, traced);
  return traced;
}

void trace_path(const MusclePath& path, const Pose& pose, TracedPath& traced) {
  check_path(path);
  const auto in_world = [&](size_t i) {
    return Vec3(frame_of_point(path.points[i], pose) * path.points[i].position);
  };
  traced.length = 0.0;
  traced.points.assign(1, in_world(0));
  traced.of_point.assign(1, 0);
  for (size_t i = 0; i + 1 < path.points.size(); ++i) {
    const Vec3 from = traced.points.back(), to = in_world(i + 1);
    const WrapCylinder* wrap = wrap_of(path, static_cast<int>(i));
    traced.length += wrap ? trace_wrap(section_of(*wrap, pose[wrap->body]), from, to, traced.points)
                          : (to - from).norm();
    traced.of_point.push_back(static_cast<int>(traced.points.size()));
    traced.points.push_back(to);
  }
}

}  // namespace thew::muscles
