// SPDX-License-Identifier: Apache-2.0
#include "muscles/path.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "rig/math.h"

namespace thew {
namespace {

// The cylinder's own frame in the world. Columns 0 and 1 span its section, 2 is its axis. For a
// turn of -1 column 1 is mirrored, so that the path always goes round counter-clockwise.
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

// An end of the segment in the section. A point within the radius counts as lying on the surface.
struct End {
  Vec3 p;              // x, y in the section, z along the axis
  double tangent = 0;  // m, from the point to where its tangent touches the circle
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

// Angle (rad) that the shortest path on the right side lies on the cylinder; negative: the straight
// segment, which either passes the centre at a radius or more on its left or has it beyond one end.
double wrap_angle(double radius, const End& a, const End& b) {
  const Vec3 along = b.p - a.p;
  const double length = std::sqrt(dot(along, along));
  const bool centre_beyond_an_end = dot(a.p, along) >= 0.0 || dot(b.p, along) <= 0.0;
  if (centre_beyond_an_end || cross(a.p, b.p) >= radius * length) return -1.0;
  double between = arc_tan2(cross(a.p, b.p), dot(a.p, b.p));
  if (between < 0.0) between += 2.0 * kPi;
  return std::max(between - arc_tan2(a.tangent, radius) - arc_tan2(b.tangent, radius), 0.0);
}

// Where a tangent from `end` touches: the end's direction turned ahead (side 1) or back (-1).
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
  const double angle = wrap_angle(section.radius, a, b);
  if (angle < 0.0) {
    const Vec3 along = b.p - a.p;
    const double length2 = dot(along, along);
    const double t = length2 > 0.0 ? std::clamp(-dot(a.p, along) / length2, 0.0, 1.0) : 0.0;
    for (int i = 0; i < kArcPoints; ++i) emit(a.p + t * along);
    return along.norm();
  }
  // Unrolled, a helix is a straight line: z is linear in the length covered in the section.
  const double flat = a.tangent + section.radius * angle + b.tangent;
  const double slope = flat > 0.0 ? (b.p.z() - a.p.z()) / flat : 0.0;
  const Vec3 touch = touch_point(section.radius, a, 1.0);
  for (int i = 0; i < kArcPoints; ++i) {
    const double turned = angle * i / (kArcPoints - 1);
    const auto [s, c] = sin_cos(turned);
    emit({c * touch.x() - s * touch.y(), s * touch.x() + c * touch.y(),
          a.p.z() + slope * (a.tangent + section.radius * turned)});
  }
  return flat * std::sqrt(1.0 + slope * slope);
}

// The wrap of each segment, null where there is none.
std::vector<const WrapCylinder*> wraps_by_segment(const MusclePath& path) {
  const auto refuse = [](const std::string& what) {
    throw Error(ExitCode::kUsage, "muscle path: " + what);
  };
  if (path.points.size() < 2) refuse("it lacks an origin or an insertion; add path points");
  std::vector<const WrapCylinder*> wraps(path.points.size() - 1, nullptr);
  for (const WrapCylinder& wrap : path.wraps) {
    const std::string segment = "segment " + std::to_string(wrap.segment);
    if (wrap.segment < 0 || wrap.segment >= static_cast<int>(wraps.size())) {
      refuse(segment + " has a wrap but does not exist; count segments from 0 at the origin");
    }
    if (wraps[wrap.segment]) refuse(segment + " has two wraps; put a path point between them");
    wraps[wrap.segment] = &wrap;
  }
  return wraps;
}

}  // namespace

TracedPath trace_path(const MusclePath& path, const Pose& pose) {
  const std::vector<const WrapCylinder*> wraps = wraps_by_segment(path);
  const auto in_world = [&](size_t i) {
    return Vec3(pose[path.points[i].body] * path.points[i].position);
  };
  TracedPath traced;
  traced.points.reserve(path.points.size() + kArcPoints * path.wraps.size());
  traced.points.push_back(in_world(0));
  for (size_t i = 0; i < wraps.size(); ++i) {
    const Vec3 from = traced.points.back(), to = in_world(i + 1);
    traced.length +=
        wraps[i] ? trace_wrap(section_of(*wraps[i], pose[wraps[i]->body]), from, to, traced.points)
                 : (to - from).norm();
    traced.points.push_back(to);
  }
  return traced;
}

}  // namespace thew
