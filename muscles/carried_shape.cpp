// SPDX-License-Identifier: Apache-2.0
#include "muscles/carried_shape.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "muscles/frames.h"
#include "rig/math.h"
#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

constexpr int kSamples = 129;    // of a curve; chosen by trial
constexpr double kTaper = 0.15;  // share of the belly at either end, over which a scale fades out

// Sets the samples at `points`. Transported frames are turned by twist.at_origin, and from sample
// `from` on by an evenly growing part of twist.shared.
void set_samples(const std::vector<Vec3>& points, const CurveFrames& frames, const Twist& twist,
                 int from, CarryCurve& curve) {
  const int n = static_cast<int>(points.size());
  const SinCos step = sin_cos(twist.shared / (n - 1 - from));
  SinCos turn = sin_cos(twist.at_origin);
  curve.samples.resize(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 &normal = frames.normal[i], binormal = frames.tangent[i].cross(normal);
    curve.samples[i] = {to_point(points[i]), to_point(frames.tangent[i]),
                        to_point(turn.cos * normal + turn.sin * binormal),
                        to_point(turn.cos * binormal - turn.sin * normal)};
    if (i >= from) {
      turn = {turn.sin * step.cos + turn.cos * step.sin, turn.cos * step.cos - turn.sin * step.sin};
    }
  }
}

// Sets work.points to the rounded samples of the traced path.
void round_path(double corner, CarryWork& work) {
  const TracedPath& path = work.traced;
  resample(path.points, kSamples, work.scratch, work.even);
  const double spacing = path.length / (kSamples - 1);
  round_corners(spacing, std::min(corner, 0.1 * path.length), work.scratch, work.even);
  resample(work.even, kSamples, work.scratch, work.points);
}

// The curve at a share `part` of its length. Frames are interpolated linearly and so are only
// nearly orthonormal, at rest as in any pose.
[[gnu::always_inline]] inline CurveSample interpolate(const CarryCurve& curve, double part) {
  const double at = std::min(std::max(part, 0.0), 1.0) * (kSamples - 1);
  const int i = std::min(static_cast<int>(at), kSamples - 2);
  const double t = at - i;
  const CurveSample &a = curve.samples[i], &b = curve.samples[i + 1];
  return {a.point + t * (b.point - a.point), a.tangent + t * (b.tangent - a.tangent),
          a.normal + t * (b.normal - a.normal), a.binormal + t * (b.binormal - a.binormal)};
}

Mat3 frame_of(const CurveSample& sample) {
  Mat3 frame;
  frame << to_vec(sample.tangent), to_vec(sample.normal), to_vec(sample.binormal);
  return frame;
}

// Coordinates of x in the frame of a sample.
Vec3 coordinates_in(const CurveSample& sample, const Point& x) {
  return frame_of(sample).inverse() * to_vec(x - sample.point);
}

// Share of the length of the curve at which the section of each node lies.
std::vector<double> parts_of(const CarryCurve& curve, const TriMesh& mesh) {
  std::vector<Vec3> line;
  for (const CurveSample& sample : curve.samples) line.push_back(to_vec(sample.point));
  return feet_along(line, mesh);
}

// Integral of smoothstep(0, 1, .) from 0 to t.
double smoothstep_integral(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (1.0 - 0.5 * t);
}

// Rate at which the change of length is taken up along the path (1/m): 0 in the tendons, constant
// in the middle of the belly, with smoothsteps between. share() is its integral. s in m along the
// rest path.
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

// The path at rest as a curve. Its first frame has any normal that fits the tangent.
CarryCurve rest_curve(const TracedPath& traced, double corner) {
  CarryWork work;
  work.traced = traced;
  round_path(corner, work);
  const Vec3 t = tangent_at(work.points, 0);
  const Vec3 n = t.unitOrthogonal();
  Mat3 first;
  first << t, n, t.cross(n);
  transport_frames(work.points, first, work.frames);
  CarryCurve curve;
  set_samples(work.points, work.frames, {}, 0, curve);
  return curve;
}

// The sample (fractional) at point k of the path, by its position on the traced path.
double sample_of_point(const TracedPath& traced, int k) {
  double before = 0.0, all = 0.0;
  for (int i = 1; i < static_cast<int>(traced.points.size()); ++i) {
    all += (traced.points[i] - traced.points[i - 1]).norm();
    if (i == traced.of_point[k]) before = all;
  }
  return all > 0.0 ? before / all * (kSamples - 1) : 0.0;
}

// Groups successive points of the path that one body carries into runs.
void set_runs(const TracedPath& traced, const Pose& rest_pose, CarriedShape& shape) {
  const std::vector<PathPoint>& points = shape.path.points;
  const auto same = [&](const PathPoint& a, const PathPoint& b) {
    return a.body == b.body && a.with == b.with && a.share == b.share;
  };
  const double middle = 0.5 * (shape.belly[0] + shape.belly[1]) / traced.length * (kSamples - 1);
  const int count = static_cast<int>(points.size());
  for (int begin = 0, end = 0; begin < count; begin = end) {
    while (end < count && same(points[begin], points[end])) ++end;
    Vec3 along = Vec3::UnitX();
    if (begin > 0) {
      const Vec3 between =
          0.5 * (traced.points[traced.of_point[begin - 1]] + traced.points[traced.of_point[begin]]);
      const Vec3 before = between - traced.points.front(), after = traced.points.back() - between;
      along = before.norm() > after.norm() ? before : after;
      const double at = 0.5 * (sample_of_point(traced, begin - 1) + sample_of_point(traced, begin));
      if (at < middle) ++shape.twists_of_origin;
    }
    shape.runs.push_back(
        {begin, end - 1, frame_of_point(points[begin], rest_pose).linear(), along.normalized()});
  }
}

StretchProfile stretch_profile(const CarriedShape& shape) {
  const double length = shape.belly[1] - shape.belly[0];
  return {shape.belly[0], shape.belly[1], std::min(shape.lengths.junction_length, 0.25 * length)};
}

double coordinate_in(const std::array<double, 2>& belly, double along) {
  return std::clamp((along - belly[0]) / (belly[1] - belly[0]), 0.0, 1.0);
}

}  // namespace

std::vector<double> belly_coordinates(const TriMesh& mesh, const MusclePath& path,
                                      const Pose& rest_pose, const std::array<double, 2>& belly,
                                      const Lengths& lengths) {
  const TracedPath traced = trace_path(path, rest_pose);
  const CarryCurve curve = rest_curve(traced, lengths.corner_length);
  std::vector<double> coordinates;
  for (const double part : parts_of(curve, mesh)) {
    coordinates.push_back(coordinate_in(belly, part * traced.length));
  }
  return coordinates;
}

CarriedShape make_carried_shape(const TriMesh& mesh, const MusclePath& path, const Pose& rest_pose,
                                const std::array<double, 2>& belly,
                                const std::vector<double>& weights, double twist_from,
                                const Lengths& lengths) {
  assert(weights.size() == mesh.vertices.size());
  CarriedShape shape;
  shape.path = path;
  shape.lengths = lengths;
  const TracedPath traced = trace_path(path, rest_pose);
  const CarryCurve curve = rest_curve(traced, lengths.corner_length);
  shape.rest_path_length = traced.length;
  shape.belly = belly;
  shape.twist_from = twist_from;
  const Transform& origin = rest_pose[path.points.front().body];
  const Transform& insertion = rest_pose[path.points.back().body];
  shape.rest_end_frames = {origin.rotation().transpose() * frame_of(curve.samples.front()),
                           insertion.rotation().transpose() * frame_of(curve.samples.back())};
  for (const CurveSample& sample : curve.samples) {
    shape.rest.tangent.push_back(to_vec(sample.tangent));
    shape.rest.normal.push_back(to_vec(sample.normal));
  }
  set_runs(traced, rest_pose, shape);
  const StretchProfile profile = stretch_profile(shape);
  const size_t nodes = mesh.vertices.size();
  const std::vector<double> parts = parts_of(curve, mesh);
  shape.offset.resize(nodes);
  shape.bulge = weights;
  for (auto* values : {&shape.along, &shape.stretch_share, &shape.stretch_rate, &shape.inner})
    values->resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    const double part = parts[i], s = part * traced.length;
    shape.along[i] = s;
    shape.offset[i] = coordinates_in(interpolate(curve, part), to_point(mesh.vertices[i]));
    shape.stretch_share[i] = profile.share(s);
    shape.stretch_rate[i] = profile.rate(s);
    const double u = belly_coordinate(shape, static_cast<int>(i));
    if (shape.stretch_rate[i] > 0.0)
      shape.inner[i] = smoothstep(0.0, kTaper, u) * smoothstep(0.0, kTaper, 1.0 - u);
  }
  // b keeps the volume to first order: it is sum A rate / sum A w rate over the nodes, where A is
  // the part of the cross-section that the triangles of the node enclose.
  double plain = 0.0, weighted = 0.0;
  for (const Triangle& tri : mesh.triangles) {
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]], &c = mesh.vertices[tri[2]];
    const Vec3 outward = (b - a).cross(c - a);
    for (int k : tri) {
      const CurveSample at = interpolate(curve, shape.along[k] / traced.length);
      const double wedge = dot(to_point(outward),
                               shape.offset[k].y() * at.normal + shape.offset[k].z() * at.binormal);
      plain += wedge * shape.stretch_rate[k];
      weighted += wedge * shape.stretch_rate[k] * shape.bulge[k];
    }
  }
  const double b = weighted > 0.0 ? plain / weighted : 0.0;
  for (double& w : shape.bulge) w *= b;
  return shape;
}

CarriedShape make_fixed_shape(const TriMesh& mesh, const std::vector<int>& fixed_to,
                              const Pose& rest_pose) {
  CarriedShape shape;
  const size_t nodes = mesh.vertices.size();
  shape.belly = {0.0, 1.0};
  shape.rest_path_length = 1.0;
  shape.fixed_to = fixed_to;
  for (std::vector<double>* values :
       {&shape.along, &shape.stretch_share, &shape.stretch_rate, &shape.bulge, &shape.inner}) {
    values->assign(nodes, 0.0);
  }
  for (size_t i = 0; i < nodes; ++i) {
    const Vec3& p = mesh.vertices[i];
    shape.offset.push_back(fixed_to[i] < 0 ? p : rest_pose[fixed_to[i]].inverse() * p);
  }
  return shape;
}

namespace {

// Finds the bodies along the traced path in the pose, and the twists between them.
void find_bodies(const CarriedShape& shape, const Pose& pose, CarryWork& work) {
  auto& [traced, even, points, frames, bodies, scratch, twists, around, cleared] = work;
  bodies.clear();
  twists.clear();
  for (const CarriedShape::Run& run : shape.runs) {
    const Mat3 now = frame_of_point(shape.path.points[run.first], pose).linear();
    FrameBody body{now * run.rest_rotation.transpose(), 0.0, sample_of_point(traced, run.first),
                   sample_of_point(traced, run.last)};
    if (!bodies.empty()) {
      const FrameBody& before = bodies.back();
      twists.push_back(turn_about(run.along, before.turn.transpose() * body.turn));
      body.twist = before.twist + twists.back();
    }
    bodies.push_back(body);
  }
}

// The least cosine between neighbouring tangents.
double sharpest_bend(const CurveFrames& frames) {
  double least = 1.0;
  for (int i = 1; i < kSamples; ++i) {
    least = std::min(least, frames.tangent[i - 1].dot(frames.tangent[i]));
  }
  return least;
}

// To what share (0..1) the bodies give the frames instead of transport. It rises with the angle at
// an end from 115 to 135 degrees, with the bend between two samples, and with the difference
// between the twists from 70 to 120 degrees (`end` and `bend` are cosines). Chosen by trial.
double share_of_bodies(double end, double bend, double doubt) {
  constexpr double kEnd[] = {0.42262, 0.70711}, kBend[] = {-0.64279, -0.25882};
  constexpr double kDoubt[] = {70.0 * kDegree, 120.0 * kDegree};
  return std::max({smoothstep(kEnd[0], kEnd[1], -end), smoothstep(kBend[0], kBend[1], -bend),
                   smoothstep(kDoubt[0], kDoubt[1], doubt)});
}

void follow_bodies(const std::vector<FrameBody>& bodies, const CurveFrames& rest,
                   const Twist& twist, int from, double share, CarryCurve& curve) {
  for (int i = 0; i < kSamples; ++i) {
    CurveSample& sample = curve.samples[i];
    const double angle =
        twist.at_origin + twist.shared_of_bodies * std::max(i - from, 0) / (kSamples - 1 - from);
    const Vec3 t = to_vec(sample.tangent), by_bodies = carried_normal(bodies, rest, i, t, angle);
    const Vec3 normal = ((1.0 - share) * to_vec(sample.normal) + share * by_bodies).normalized();
    sample.normal = to_point(normal);
    sample.binormal = to_point(t.cross(normal));
  }
}

// Leads the curve around bones, which makes path and curve longer.
void give_way(const CarriedShape& shape, const Pose& pose, CarryWork& work) {
  work.even = work.points;
  if (!shape.give_way(pose, work.traced.length, work.even, work.around)) return;
  double before = 0.0, after = 0.0;
  for (int i = 1; i < kSamples; ++i) {
    before += (work.points[i] - work.points[i - 1]).norm();
    after += (work.even[i] - work.even[i - 1]).norm();
  }
  work.traced.length *= after / before;
  resample(work.even, kSamples, work.scratch, work.points);
}

}  // namespace

CarriedPose carry_pose(const CarriedShape& shape, const Pose& pose) {
  CarryWork work;
  CarriedPose out;
  carry_pose(shape, pose, work, out);
  return out;
}

void carry_pose(const CarriedShape& shape, const Pose& pose, CarryWork& work, CarriedPose& out) {
  if (!shape.fixed_to.empty()) {
    out.bodies = pose;
    return;
  }
  trace_path(shape.path, pose, work.traced);
  round_path(shape.lengths.corner_length, work);
  if (shape.give_way) give_way(shape, pose, work);
  out.path_length = work.traced.length;
  const std::vector<Vec3>& points = work.points;
  const CurveFrames& frames = work.frames;
  out.change = out.path_length - shape.rest_path_length;
  const auto carried_end = [&](int end) {
    const auto& point = end == 0 ? shape.path.points.front() : shape.path.points.back();
    return Mat3(pose[point.body].rotation() * shape.rest_end_frames[end]);
  };
  const Mat3 first = carried_end(0), last = carried_end(1);
  const Vec3 begins = tangent_at(points, 0), ends = tangent_at(points, kSamples - 1);
  transport_frames(points, fitted_frame(first, begins), work.frames);
  const Vec3 wanted = fitted_frame(last, ends).col(1), binormal = ends.cross(frames.normal.back());
  find_bodies(shape, pose, work);
  const Twist twist =
      share_twist(work.twists, arc_tan2(wanted.dot(binormal), wanted.dot(frames.normal.back())),
                  shape.twists_of_origin);
  const int from = std::min(
      static_cast<int>(shape.twist_from / shape.rest_path_length * (kSamples - 1)), kSamples - 2);
  set_samples(points, frames, twist, from, out.curve);
  const double off = std::min(first.col(0).dot(begins), last.col(0).dot(ends));
  const double share = share_of_bodies(off, sharpest_bend(frames), twist.doubt);
  if (share > 0.0) follow_bodies(work.bodies, shape.rest, twist, from, share, out.curve);
}

double stretch_at(const CarriedShape& shape, const CarriedPose& pose, int node) {
  // A belly shortened to nothing would turn inside out; 0.2 is far below what living fibres reach.
  return std::max(1.0 + shape.stretch_rate[node] * pose.change, 0.2);
}

namespace {

// The curve at the position to which a node is carried, and the factor g of its offset.
struct CarriedNode {
  CurveSample at;
  double swelling;
};
[[gnu::always_inline]] inline CarriedNode carry_node(const CarriedShape& shape,
                                                     const CarriedPose& pose, bool swell,
                                                     size_t i) {
  const double s = shape.along[i] + shape.stretch_share[i] * pose.change;
  double g = 1.0;
  if (swell && shape.stretch_rate[i] > 0.0) {
    const double shrinking = 1.0 / stretch_at(shape, pose, i) - 1.0;
    g = std::sqrt(std::max(1.0 + shape.bulge[i] * shrinking, 0.04));
  }
  return {interpolate(pose.curve, s / pose.path_length), g};
}

}  // namespace

THEW_VECTORISED
void carried_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                       Points& positions, double scale, Points* scaled) {
  const size_t nodes = shape.along.size();
  positions.resize(nodes);
  for (size_t i = 0; i < nodes && !shape.fixed_to.empty(); ++i) {
    const int body = shape.fixed_to[i];
    positions[i] = to_point(body < 0 ? shape.offset[i] : pose.bodies[body] * shape.offset[i]);
  }
  if (!shape.fixed_to.empty()) return;
  if (scaled) scaled->resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    const auto [at, swelling] = carry_node(shape, pose, swell, i);
    const Vec3& offset = shape.offset[i];
    const Point axis = at.point + offset.x() * at.tangent;
    const Point away = swelling * (offset.y() * at.normal + offset.z() * at.binormal);
    positions[i] = axis + away;
    if (scaled) (*scaled)[i] = axis + (1.0 + (scale - 1.0) * shape.inner[i]) * away;
  }
}

std::vector<Vec3> profile_offsets(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                                  const Points& x) {
  std::vector<Vec3> offsets;
  for (size_t i = 0; i < x.size(); ++i) {
    const auto [at, g] = carry_node(shape, pose, swell, i);
    const Vec3& offset = shape.offset[i];
    offsets.push_back(coordinates_in(at, x[i]) - Vec3(offset.x(), g * offset.y(), g * offset.z()));
  }
  return offsets;
}

THEW_VECTORISED
void profiled_positions(const CarriedShape& shape, const CarriedPose& pose, bool swell,
                        const CarriedProfile& profile, Points& positions) {
  const size_t nodes = shape.along.size();
  const std::vector<double>& knots = profile.change;
  const auto after = std::upper_bound(knots.begin(), knots.end(), pose.change);
  const size_t high = std::min<size_t>(after - knots.begin(), knots.size() - 1);
  const size_t low = after == knots.begin() ? high : after - knots.begin() - 1;
  const double t = low < high ? (pose.change - knots[low]) / (knots[high] - knots[low]) : 0.0;
  positions.resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    const auto [at, g] = carry_node(shape, pose, swell, i);
    const Point one = to_point(profile.offset[low][i]), two = to_point(profile.offset[high][i]);
    const Point offset =
        to_point(shape.offset[i]) * Point{1.0, g, g, 0.0} + (1.0 - t) * one + t * two;
    positions[i] =
        at.point + offset[0] * at.tangent + offset[1] * at.normal + offset[2] * at.binormal;
  }
}

double belly_coordinate(const CarriedShape& shape, int node) {
  return coordinate_in(shape.belly, shape.along[node]);
}

std::array<double, 3> fibre_coordinates(const CarriedShape& shape, int node) {
  const double u = belly_coordinate(shape, node);
  return {shape.along[node] / shape.rest_path_length,
          arc_tan2(shape.offset[node].z(), shape.offset[node].y()),
          smoothstep(0.0, 0.12, u) * smoothstep(0.0, 0.12, 1.0 - u)};
}

void curve_at(const CarriedShape& shape, const CarriedPose& pose, double along, Vec3& point,
              Vec3& tangent) {
  const StretchProfile profile = stretch_profile(shape);
  const CurveSample at =
      interpolate(pose.curve, (along + profile.share(along) * pose.change) / pose.path_length);
  point = to_vec(at.point);
  tangent = to_vec(at.tangent).normalized();
}

}  // namespace thew::muscles
