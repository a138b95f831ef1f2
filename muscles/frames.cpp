// SPDX-License-Identifier: Apache-2.0
#include "muscles/frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rig/math.h"

namespace thew::muscles {
namespace {

double nearest_foot(const std::vector<Vec3>& line, const Vec3& x) {
  double best = std::numeric_limits<double>::infinity(), foot = 0.0;
  for (size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3 d = line[i + 1] - line[i];
    const double t = std::clamp(d.dot(x - line[i]) / d.squaredNorm(), 0.0, 1.0);
    const double distance = (line[i] + t * d - x).squaredNorm();
    if (distance < best) {
      best = distance;
      foot = (i + t) / (line.size() - 1);
    }
  }
  return foot;
}

}  // namespace

std::vector<double> feet_along(const std::vector<Vec3>& line, const TriMesh& mesh) {
  // Distance of the feet of two neighbours over their own. On the inside of an arc it is radius /
  // (radius - offset).
  constexpr double kSure = 1.5, kLeaps = 3.0;
  constexpr int kSweeps = 1000;
  constexpr double kConverged = 1e-12;
  double length = 0.0;
  for (size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  std::vector<double> nearest;
  for (const Vec3& p : mesh.vertices) nearest.push_back(nearest_foot(line, p));
  std::vector<double> stretch(nearest.size(), 0.0);
  std::vector<std::vector<int>> neighbours(nearest.size());
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double apart = (mesh.vertices[a] - mesh.vertices[b]).norm();
      const double of_feet = length * std::abs(nearest[a] - nearest[b]);
      for (const int node : {a, b}) stretch[node] = std::max(stretch[node], of_feet / apart);
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    }
  }
  std::vector<double> feet = nearest;
  double moved = 1.0;
  for (int sweep = 0; sweep < kSweeps && moved > kConverged; ++sweep) {
    moved = 0.0;
    for (size_t i = 0; i < feet.size(); ++i) {
      const double doubt = smoothstep(kSure, kLeaps, stretch[i]);
      if (!(doubt > 0.0)) continue;
      double sum = 0.0;
      for (const int j : neighbours[i]) sum += feet[j];
      const double foot = nearest[i] + doubt * (sum / neighbours[i].size() - nearest[i]);
      moved = std::max(moved, std::abs(foot - feet[i]));
      feet[i] = foot;
    }
  }
  return feet;
}

void resample(const std::vector<Vec3>& points, int count, std::vector<double>& s,
              std::vector<Vec3>& out) {
  s.assign(points.size(), 0.0);
  for (size_t i = 1; i < points.size(); ++i) s[i] = s[i - 1] + (points[i] - points[i - 1]).norm();
  out.resize(count);
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
}

// Solves p - radius^2 p'' = p_in with fixed ends twice, each a tridiagonal system (Thomas
// algorithm). Unlike a whole number of averaging passes this is smooth in the pose.
void round_corners(double spacing, double radius, std::vector<double>& inverse,
                   std::vector<Vec3>& p) {
  constexpr int kPasses = 2;
  const double a = radius * radius / (spacing * spacing);
  const int n = static_cast<int>(p.size());
  inverse.assign(n, 0.0);
  for (int i = 1; i + 1 < n; ++i) inverse[i] = 1.0 / (1.0 + 2.0 * a - a * (a * inverse[i - 1]));
  for (int pass = 0; pass < kPasses; ++pass) {
    for (int i = 1; i + 1 < n; ++i) p[i] = inverse[i] * (p[i] + a * p[i - 1]);
    for (int i = n - 2; i >= 1; --i) p[i] += a * inverse[i] * p[i + 1];
  }
}

Vec3 tangent_at(const std::vector<Vec3>& points, int i) {
  const int last = static_cast<int>(points.size()) - 1;
  return (points[std::min(i + 1, last)] - points[std::max(i - 1, 0)]).normalized();
}

void transport_frames(const std::vector<Vec3>& points, const Mat3& first, CurveFrames& frames) {
  const int n = static_cast<int>(points.size());
  frames.tangent.resize(n);
  frames.normal.resize(n);
  frames.tangent[0] = first.col(0);
  frames.normal[0] = first.col(1);
  for (int i = 1; i < n; ++i) {
    const Vec3 &before = frames.tangent[i - 1], &turned = frames.normal[i - 1];
    const Vec3 t = tangent_at(points, i);
    frames.tangent[i] = t;
    frames.normal[i] = turned - turned.dot(t) / std::max(1.0 + before.dot(t), 1e-9) * (before + t);
  }
}

Mat3 fitted_frame(const Mat3& frame, const Vec3& tangent) {
  const Vec3 axis = frame.col(0).cross(tangent);
  const double c = frame.col(0).dot(tangent);
  Mat3 k;
  k << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Mat3(Mat3::Identity() + k + k * k / std::max(1.0 + c, 1e-9)) * frame;
}

double turn_about(const Vec3& axis, const Mat3& turn) {
  const Eigen::Quaterniond q(turn);
  const double angle = 2.0 * arc_tan2(q.vec().dot(axis), q.w());
  return angle > kPi ? angle - 2.0 * kPi : angle <= -kPi ? angle + 2.0 * kPi : angle;
}

Twist share_twist(const std::vector<double>& twists, double at_insertion, int of_origin) {
  constexpr double kLetGoFrom = 0.75 * kPi;  // rad, twist from which a tendon lets go
  double total = 0.0, origin = 0.0, insertion = 0.0;
  for (int k = 0; k < static_cast<int>(twists.size()); ++k) {
    total += twists[k];
    (k < of_origin ? origin : insertion) +=
        smoothstep(kLetGoFrom, kPi, std::abs(twists[k])) * twists[k];
  }
  const double rounds = std::round((total - at_insertion) / (2.0 * kPi));
  const double exact = at_insertion + 2.0 * kPi * rounds, let_go = origin + insertion;
  return {origin, exact - let_go, total - let_go, std::abs(exact - total)};
}

Vec3 carried_normal(const std::vector<FrameBody>& bodies, const CurveFrames& rest, int i,
                    const Vec3& t, double angle) {
  constexpr double kElsewhere = 0.1;  // weight far from the points of a body; 1.1 at them
  const double last = static_cast<double>(rest.tangent.size() - 1);
  Vec3 sum = Vec3::Zero();
  for (size_t k = 0; k < bodies.size(); ++k) {
    const FrameBody& body = bodies[k];
    // The weight falls linearly from 1 at the points of this body to 0 at those of the next body.
    const double before = k > 0 ? body.first - bodies[k - 1].last : last,
                 after = k + 1 < bodies.size() ? bodies[k + 1].first - body.last : last;
    const double below = (body.first - i) / std::max(before, 1.0),
                 above = (i - body.last) / std::max(after, 1.0);
    const double weight = kElsewhere + std::clamp(1.0 - std::max(below, above), 0.0, 1.0);
    const Vec3 tangent = body.turn * rest.tangent[i], normal = body.turn * rest.normal[i];
    const auto [s, c] = sin_cos(angle - body.twist);
    const Vec3 turned = c * normal + s * tangent.cross(normal);
    // The normal after the smallest rotation from `tangent` to t, multiplied by 1 + tangent . t.
    sum += weight * ((1.0 + tangent.dot(t)) * turned - turned.dot(t) * (tangent + t));
  }
  return (sum - sum.dot(t) * t).normalized();
}

}  // namespace thew::muscles
