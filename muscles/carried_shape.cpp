// SPDX-License-Identifier: Apache-2.0
#include "muscles/carried_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rig/math.h"

namespace thew {
namespace {

constexpr int kSamples = 129;
constexpr double kRounding = 0.007;  // m, length over which corners are rounded
constexpr double kJunction = 0.012;  // m, over which tendon turns into belly

std::vector<double> arc_lengths(const std::vector<Vec3>& points) {
  std::vector<double> s(points.size(), 0.0);
  for (size_t i = 1; i < points.size(); ++i) s[i] = s[i - 1] + (points[i] - points[i - 1]).norm();
  return s;
}

std::vector<Vec3> resample(const std::vector<Vec3>& points, int count) {
  const std::vector<double> s = arc_lengths(points);
  std::vector<Vec3> out(count);
  size_t segment = 0;
  for (int i = 0; i < count; ++i) {
    const double at = s.back() * i / (count - 1);
    while (segment + 2 < points.size() && s[segment + 1] < at) ++segment;
    const double length = s[segment + 1] - s[segment];
    const double t = length > 0.0 ? std::clamp((at - s[segment]) / length, 0.0, 1.0) : 0.0;
    out[i] = points[segment] + t * (points[segment + 1] - points[segment]);
  }
  out.front() = points.front();
  out.back() = points.back();
  return out;
}

// p - radius^2 p'' = p_in with fixed ends: a tridiagonal system (Thomas). Smooth in the pose,
// unlike a count of averaging passes.
void round_corners(std::vector<Vec3>& p, double spacing, double radius) {
  const double a = radius * radius / (spacing * spacing);
  const int n = static_cast<int>(p.size());
  std::vector<double> c(n, 0.0);
  for (int i = 1; i + 1 < n; ++i) {
    const double pivot = 1.0 + 2.0 * a - (i > 1 ? a * c[i - 1] : 0.0);
    c[i] = a / pivot;
    p[i] = (p[i] + a * p[i - 1]) / pivot;  // p[0] is fixed; for i > 1 p[i-1] is already reduced
  }
  for (int i = n - 2; i >= 1; --i) p[i] += c[i] * p[i + 1];
}

// The smallest rotation that takes unit vector a to unit vector b.
Mat3 smallest_rotation(const Vec3& a, const Vec3& b) {
  const Vec3 axis = a.cross(b);
  const double c = a.dot(b);
  Mat3 k;
  k << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Mat3::Identity() + k + k * k / std::max(1.0 + c, 1e-9);
}

Vec3 tangent_at(const std::vector<Vec3>& p, int i) {
  const int last = static_cast<int>(p.size()) - 1;
  return (p[std::min(i + 1, last)] - p[std::max(i - 1, 0)]).normalized();
}

// Frames from the origin's by smallest rotations; the twist left over against the insertion's frame
// is shared out along the curve.
void set_frames(const Mat3& first, const Mat3* last, CarryCurve& curve) {
  const int n = static_cast<int>(curve.points.size());
  curve.frames.resize(n);
  curve.frames[0] = first;
  for (int i = 1; i < n; ++i) {
    const Vec3 t = tangent_at(curve.points, i);
    curve.frames[i] = smallest_rotation(curve.frames[i - 1].col(0), t) * curve.frames[i - 1];
  }
  if (!last) return;
  const Mat3& end = curve.frames[n - 1];
  const Vec3 wanted = last->col(1);
  const double twist = arc_tan2(wanted.dot(end.col(2)), wanted.dot(end.col(1)));
  for (int i = 0; i < n; ++i) {
    curve.frames[i] = rotation_about(curve.frames[i].col(0), twist * i / (n - 1)) * curve.frames[i];
  }
}

CarryCurve rounded_curve(const TracedPath& path) {
  CarryCurve curve;
  curve.points = resample(path.points, kSamples);
  const double spacing = path.length / (kSamples - 1);
  const double radius = std::min(kRounding, 0.1 * path.length);
  for (int pass = 0; pass < 2; ++pass) round_corners(curve.points, spacing, radius);
  curve.points = resample(curve.points, kSamples);
  curve.length = arc_lengths(curve.points).back();
  return curve;
}

struct CurvePoint {
  Vec3 point;
  Mat3 frame;  // interpolated, so only nearly orthonormal: the same at rest and later
};

// `part`: of the curve's length, 0..1.
CurvePoint interpolate(const CarryCurve& curve, double part) {
  const double at = std::clamp(part, 0.0, 1.0) * (kSamples - 1);
  const int i = std::min(static_cast<int>(at), kSamples - 2);
  const double t = at - i;
  return {curve.points[i] + t * (curve.points[i + 1] - curve.points[i]),
          curve.frames[i] + t * (curve.frames[i + 1] - curve.frames[i])};
}

// Part of the curve's length at which it is nearest to x.
double nearest_part(const CarryCurve& curve, const Vec3& x) {
  double best = std::numeric_limits<double>::infinity(), part = 0.0;
  for (int i = 0; i + 1 < kSamples; ++i) {
    const Vec3 d = curve.points[i + 1] - curve.points[i];
    const double t = std::clamp(d.dot(x - curve.points[i]) / d.squaredNorm(), 0.0, 1.0);
    const double distance = (curve.points[i] + t * d - x).squaredNorm();
    if (distance < best) {
      best = distance;
      part = (i + t) / (kSamples - 1);
    }
  }
  return part;
}

// Integral of smoothstep over t in 0..1, up to t.
double smoothstep_integral(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (1.0 - 0.5 * t);
}

// Stretch rate along the belly: 0 in the tendons, constant in the middle, smoothsteps between.
struct StretchProfile {
  double from, to, ramp;
  double total() const { return to - from - ramp; }
  double rate(double s) const {
    return smoothstep(from, from + ramp, s) * (1.0 - smoothstep(to - ramp, to, s)) / total();
  }
  double share(double s) const {
    const double rise = ramp * smoothstep_integral((s - from) / ramp);
    const double flat = std::clamp(s - from - ramp, 0.0, to - from - 2.0 * ramp);
    const double t = std::clamp((s - (to - ramp)) / ramp, 0.0, 1.0);
    return (rise + flat + ramp * (t - smoothstep_integral(t))) / total();
  }
};

}  // namespace

CarriedShape make_carried_shape(const TriMesh& mesh, const MusclePath& path, const Pose& rest_pose,
                                const std::array<double, 2>& belly, const WeightProfile& weights) {
  CarriedShape shape;
  shape.path = path;
  const TracedPath traced = trace_path(path, rest_pose);
  CarryCurve curve = rounded_curve(traced);
  const Vec3 t = tangent_at(curve.points, 0);
  const Vec3 n = t.unitOrthogonal();
  Mat3 first;
  first << t, n, t.cross(n);
  set_frames(first, nullptr, curve);
  shape.rest_path_length = traced.length;
  shape.belly = belly;
  const Transform& origin = rest_pose[path.points.front().body];
  const Transform& insertion = rest_pose[path.points.back().body];
  shape.rest_end_frames = {origin.rotation().transpose() * curve.frames.front(),
                           insertion.rotation().transpose() * curve.frames.back()};

  const double length = shape.belly[1] - shape.belly[0];
  const StretchProfile profile{shape.belly[0], shape.belly[1], std::min(kJunction, 0.25 * length)};
  const size_t nodes = mesh.vertices.size();
  shape.along.resize(nodes);
  shape.offset.resize(nodes);
  shape.stretch_share.resize(nodes);
  shape.stretch_rate.resize(nodes);
  shape.bulge.resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    const double part = nearest_part(curve, mesh.vertices[i]);
    const CurvePoint at = interpolate(curve, part);
    const double s = part * traced.length;
    shape.along[i] = s;
    shape.offset[i] = at.frame.inverse() * (mesh.vertices[i] - at.point);
    shape.stretch_share[i] = profile.share(s);
    shape.stretch_rate[i] = profile.rate(s);
    shape.bulge[i] = profile_weight(weights, belly_coordinate(shape, static_cast<int>(i)));
  }
  // b from "the carried shape keeps its volume": b = sum A rate / sum A w rate, where the sections
  // A are weighed by the share of the volume that each node's triangles enclose.
  double plain = 0.0, weighted = 0.0;
  for (const Triangle& tri : mesh.triangles) {
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]], &c = mesh.vertices[tri[2]];
    const Vec3 outward = (b - a).cross(c - a);
    for (int k : tri) {
      const CurvePoint at = interpolate(curve, shape.along[k] / traced.length);
      const double wedge =
          outward.dot(at.frame * Vec3(0, shape.offset[k].y(), shape.offset[k].z()));
      plain += wedge * shape.stretch_rate[k];
      weighted += wedge * shape.stretch_rate[k] * shape.bulge[k];
    }
  }
  const double b = weighted > 0.0 ? plain / weighted : 0.0;
  for (double& w : shape.bulge) w *= b;
  return shape;
}

CarriedShape make_held_shape(const TriMesh& mesh, const std::vector<int>& held,
                             const Pose& rest_pose) {
  CarriedShape shape;
  const size_t nodes = mesh.vertices.size();
  shape.belly = {0.0, 1.0};
  shape.rest_path_length = 1.0;
  shape.held = held;
  for (std::vector<double>* values :
       {&shape.along, &shape.stretch_share, &shape.stretch_rate, &shape.bulge}) {
    values->assign(nodes, 0.0);
  }
  for (size_t i = 0; i < nodes; ++i) {
    const Vec3& p = mesh.vertices[i];
    shape.offset.push_back(held[i] < 0 ? p : rest_pose[held[i]].inverse() * p);
  }
  return shape;
}

CarriedPose carry_pose(const CarriedShape& shape, const Pose& pose) {
  CarriedPose out;
  if (!shape.held.empty()) {
    out.bodies = pose;
    return out;
  }
  const TracedPath traced = trace_path(shape.path, pose);
  out.path_length = traced.length;
  out.curve = rounded_curve(traced);
  out.change = traced.length - shape.rest_path_length;
  const auto end_frame = [&](int end, int sample) {
    const auto& point = end == 0 ? shape.path.points.front() : shape.path.points.back();
    const Mat3 carried = pose[point.body].rotation() * shape.rest_end_frames[end];
    return Mat3(smallest_rotation(carried.col(0), tangent_at(out.curve.points, sample)) * carried);
  };
  const Mat3 first = end_frame(0, 0), last = end_frame(1, kSamples - 1);
  set_frames(first, &last, out.curve);
  return out;
}

double stretch_at(const CarriedShape& shape, const CarriedPose& pose, int node) {
  // A belly shortened to nothing would turn inside out: 0.2 is far below any living fibre.
  return std::max(1.0 + shape.stretch_rate[node] * pose.change, 0.2);
}

namespace {

// Where a node is carried to: the curve's point there, its frame, and the node's place in it.
struct CarriedNode {
  CurvePoint at;
  Vec3 offset;
};
CarriedNode carry_node(const CarriedShape& shape, const CarriedPose& pose, double scale, bool swell,
                       int i) {
  const double s = shape.along[i] + shape.stretch_share[i] * pose.change;
  double g = 1.0;
  if (shape.stretch_rate[i] > 0.0) {
    const double swelling = 1.0 / stretch_at(shape, pose, i) - 1.0;
    if (swell) g = std::sqrt(std::max(1.0 + shape.bulge[i] * swelling, 0.04));
    if (scale != 1.0) {
      const double u = belly_coordinate(shape, i);
      g *= 1.0 + (scale - 1.0) * (smoothstep(0.0, 0.15, u) * smoothstep(0.0, 0.15, 1.0 - u));
    }
  }
  const Vec3& o = shape.offset[i];
  return {interpolate(pose.curve, s / pose.path_length), Vec3(o.x(), g * o.y(), g * o.z())};
}

}  // namespace

void carried_positions(const CarriedShape& shape, const CarriedPose& pose, double scale, bool swell,
                       Rows& positions) {
  const int nodes = static_cast<int>(shape.along.size());
  positions.resize(nodes);
  for (int i = 0; i < nodes && !shape.held.empty(); ++i) {
    const int body = shape.held[i];
    positions[i] = to_row(body < 0 ? shape.offset[i] : pose.bodies[body] * shape.offset[i]);
  }
  if (!shape.held.empty()) return;
  for (int i = 0; i < nodes; ++i) {
    const CarriedNode node = carry_node(shape, pose, scale, swell, i);
    positions[i] = to_row(node.at.point + node.at.frame * node.offset);
  }
}

std::vector<Vec3> profile_offsets(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                                  const Rows& x) {
  std::vector<Vec3> offsets;
  for (size_t i = 0; i < x.size(); ++i) {
    const CarriedNode node = carry_node(shape, pose, 1.0, swell, static_cast<int>(i));
    offsets.push_back(node.at.frame.inverse() * (to_vec(x[i]) - node.at.point) - node.offset);
  }
  return offsets;
}

void profiled_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                        const CarriedProfile& profile, Rows& positions) {
  const int nodes = static_cast<int>(shape.along.size());
  const std::vector<double>& knots = profile.change;
  const auto after = std::upper_bound(knots.begin(), knots.end(), pose.change);
  const size_t high = std::min<size_t>(after - knots.begin(), knots.size() - 1);
  const size_t low = after == knots.begin() ? high : after - knots.begin() - 1;
  const double t = low < high ? (pose.change - knots[low]) / (knots[high] - knots[low]) : 0.0;
  positions.resize(nodes);
  for (int i = 0; i < nodes; ++i) {
    const CarriedNode node = carry_node(shape, pose, 1.0, swell, i);
    const Vec3 more = (1.0 - t) * profile.offset[low][i] + t * profile.offset[high][i];
    positions[i] = to_row(node.at.point + node.at.frame * (node.offset + more));
  }
}

double belly_coordinate(const CarriedShape& shape, int node) {
  return std::clamp((shape.along[node] - shape.belly[0]) / (shape.belly[1] - shape.belly[0]), 0.0,
                    1.0);
}

std::array<double, 3> fibre_coordinates(const CarriedShape& shape, int node) {
  const double u = belly_coordinate(shape, node);
  return {shape.along[node] / shape.rest_path_length,
          arc_tan2(shape.offset[node].z(), shape.offset[node].y()),
          smoothstep(0.0, 0.12, u) * smoothstep(0.0, 0.12, 1.0 - u)};
}

void curve_at(const CarriedShape& shape, const CarriedPose& pose, double along, Vec3& point,
              Vec3& tangent) {
  const double length = shape.belly[1] - shape.belly[0];
  const StretchProfile profile{shape.belly[0], shape.belly[1], std::min(kJunction, 0.25 * length)};
  const CurvePoint at =
      interpolate(pose.curve, (along + profile.share(along) * pose.change) / pose.path_length);
  point = at.point;
  tangent = at.frame.col(0).normalized();
}

}  // namespace thew
