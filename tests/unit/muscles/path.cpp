// SPDX-License-Identifier: Apache-2.0
#include "muscles/path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rig/math.h"

namespace thew::tests {
namespace {

constexpr double kRadius = 0.02;

// Segment a-b round a cylinder of kRadius about the z axis through the origin.
TracedPath wrap_segment(const Vec3& a, const Vec3& b, double turn = 1.0) {
  const MusclePath path{{{0, a}, {0, b}}, {{0, 0, Vec3::Zero(), Vec3::UnitZ(), kRadius, turn}}};
  return trace_path(path, {Transform::Identity()});
}

double polyline_length(const std::vector<Vec3>& points) {
  double length = 0.0;
  for (size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

// A string of many short pieces that is pulled taut on the given side: each node moves to the
// middle of its neighbours and then out of the cylinder, repeatedly.
double pulled_string(const Vec3& a, const Vec3& b, double angle_a, double angle_b) {
  constexpr int kPieces = 90;
  std::vector<Vec3> x(kPieces + 1);
  for (int i = 0; i <= kPieces; ++i) {
    const double t = static_cast<double>(i) / kPieces, angle = angle_a + t * (angle_b - angle_a);
    x[i] = {0.1 * std::cos(angle), 0.1 * std::sin(angle), a.z() + t * (b.z() - a.z())};
  }
  x.front() = a;
  x.back() = b;
  for (int pass = 0; pass < 30000; ++pass) {
    for (int i = 1; i < kPieces; ++i) {
      x[i] = 0.5 * (x[i - 1] + x[i + 1]);
      const double distance = std::hypot(x[i].x(), x[i].y());
      if (distance < kRadius) x[i].head<2>() *= kRadius / distance;
    }
  }
  return polyline_length(x);
}

TEST(Path, StraightPathIsTheSumOfItsSegments) {
  const MusclePath path{{{0, {0, 0, 0}}, {0, {3, 4, 0}}, {1, {0, 0, 0}}}, {}};
  Transform moved = Transform::Identity();
  moved.translation() = Vec3(3, 4, 2);
  const TracedPath traced = trace_path(path, {Transform::Identity(), moved});
  EXPECT_DOUBLE_EQ(traced.length, 7.0);
  ASSERT_EQ(traced.points.size(), 3u);
  EXPECT_EQ(traced.points[1], Vec3(3, 4, 0));
}

TEST(Path, RefusesTwoWrapsOnOneSegmentAWrapOnNoneAndALonePoint) {
  MusclePath path{{{0, Vec3::UnitX()}, {0, Vec3::UnitY()}}, {}};
  path.wraps.assign(2, {0, 0, Vec3::Zero(), Vec3::UnitZ(), kRadius, 1.0});
  EXPECT_THROW(trace_path(path, {Transform::Identity()}), Error);
  path.wraps.pop_back();
  EXPECT_NO_THROW(trace_path(path, {Transform::Identity()}));
  path.wraps[0].segment = 1;
  EXPECT_THROW(trace_path(path, {Transform::Identity()}), Error);
  path.wraps.clear();
  path.points.pop_back();
  EXPECT_THROW(trace_path(path, {Transform::Identity()}), Error);
}

TEST(Path, HalfTurnRoundAPulley) {
  // Below the pulley on both sides, counter-clockwise: up on the right, over the top, down again.
  const Vec3 right(kRadius, -0.03, 0), left(-kRadius, -0.03, 0);
  const TracedPath traced = wrap_segment(right, left);
  EXPECT_NEAR(traced.length, 0.06 + kPi * kRadius, 1e-15);
  ASSERT_EQ(traced.points.size(), 2u + kArcPoints);
  for (int i = 1; i <= kArcPoints; ++i) EXPECT_NEAR(traced.points[i].norm(), kRadius, 1e-16);
  EXPECT_NEAR(traced.points[1 + kArcPoints / 2].y(), kRadius, 1e-16);
  // The opposite sense gives the mirror image; neither goes straight across.
  EXPECT_NEAR(wrap_segment(left, right, -1.0).length, traced.length, 1e-15);
  EXPECT_NEAR(wrap_segment(left, right, -1.0).points[1 + kArcPoints / 2].y(), kRadius, 1e-16);
}

TEST(Path, HelixIsStraightWhenUnrolled) {
  const TracedPath traced = wrap_segment({kRadius, -0.1, 0.03}, {-0.1, kRadius, 0.10});
  const double flat = 0.2 + 0.5 * kPi * kRadius;
  EXPECT_NEAR(traced.length, std::hypot(flat, 0.07), 1e-15);
  for (int i = 1; i <= kArcPoints; ++i) {
    const double covered = 0.1 + 0.5 * kPi * kRadius * (i - 1) / (kArcPoints - 1);
    EXPECT_NEAR(traced.points[i].z(), 0.03 + 0.07 * covered / flat, 1e-15);
  }
  EXPECT_NEAR(polyline_length(traced.points), traced.length, 4e-4 * traced.length);
}

TEST(Path, LengthIsThatOfAPulledString) {
  struct Case {
    Vec3 a, b;
  };
  for (const auto& [a, b] : {Case{{0.05, -0.03, 0.0}, {-0.04, -0.02, 0.03}},
                             Case{{0.03, 0.0, 0.02}, {-0.01, 0.06, -0.02}},
                             Case{{0.05, 0.02, 0.0}, {-0.02, -0.05, 0.01}}}) {
    const double angle_a = std::atan2(a.y(), a.x());
    double angle_b = std::atan2(b.y(), b.x());
    if (angle_b < angle_a) angle_b += 2.0 * kPi;
    const double taut = pulled_string(a, b, angle_a, angle_b);
    EXPECT_NEAR(wrap_segment(a, b).length, taut, 3e-4 * taut);
    // Mirrored in the plane y = 0 the sense is the opposite and the length is the same.
    const Vec3 mirror(1, -1, 1);
    EXPECT_NEAR(wrap_segment(a.cwiseProduct(mirror), b.cwiseProduct(mirror), -1.0).length,
                wrap_segment(a, b).length, 1e-15);
  }
}

TEST(Path, StraightWhereTheSegmentClearsTheCylinder) {
  const Vec3 a(0.03, -0.1, 0), b(0.03, 0.1, 0.05);  // passes on the right side: centre on the left
  EXPECT_NEAR(wrap_segment(a, b).length, (b - a).norm(), 1e-16);
  EXPECT_GT(wrap_segment(a, b, -1.0).length, (b - a).norm() + 0.02);  // over the other side
  const Vec3 near(0.03, 0, 0), far(0.1, 0.001, 0);  // the cylinder is behind an end
  for (double turn : {1.0, -1.0}) {
    const TracedPath traced = wrap_segment(near, far, turn);
    EXPECT_NEAR(traced.length, (far - near).norm(), 1e-16);
    EXPECT_EQ(traced.points.size(), 2u + kArcPoints);
    for (int i = 1; i <= kArcPoints; ++i) EXPECT_NEAR((traced.points[i] - near).norm(), 0, 1e-15);
  }
}

TEST(Path, LengthAndSlopeAreContinuousWhereTouchingBegins) {
  // b moves across the line x = kRadius, on which the segment from a just touches.
  const Vec3 a(kRadius, -0.1, 0);
  const auto length = [&](double x) { return wrap_segment(a, {kRadius + x, 0.1, 0.03}).length; };
  const double e = 1e-7;
  EXPECT_NEAR(length(-1e-12), length(1e-12), 1e-12);
  const double before = (length(2 * e) - length(0)) / (2 * e);
  const double after = (length(0) - length(-2 * e)) / (2 * e);
  EXPECT_NEAR(before, after, 1e-5);
  const Vec3 kink = wrap_segment(a, {kRadius - 1e-9, 0.1, 0.03}).points[5] -
                    wrap_segment(a, {kRadius + 1e-9, 0.1, 0.03}).points[5];
  EXPECT_LT(kink.norm(), 1e-7);  // the points do not jump either
}

// b goes around the cylinder, near it, far from it and on it. Neither the length nor a point of the
// path may jump. A path that does not leave its cylinder gradually goes from up to a full turn to
// the straight line at once.
TEST(Path, GoesRoundWithoutALeap) {
  constexpr double kStep = 1e-3 * kDegree;
  for (double from : {1.0, 1.2, 3.0, 10.0}) {
    const Vec3 a(from * kRadius, 0.0, 0.01);
    for (double to : {1.0, 1.3, 2.5, 10.0}) {
      TracedPath before;
      double most = 0.0;  // motion over that of b
      for (double angle = 0.3 * kDegree; angle < 2.0 * kPi; angle += 0.5 * kDegree) {
        for (int k = 0; k < 2; ++k) {
          const double at = angle + k * kStep;
          const Vec3 b = to * kRadius * Vec3(std::cos(at), std::sin(at), 0.0);
          TracedPath now = wrap_segment(a, b);
          for (size_t i = 0; k == 1 && i < now.points.size(); ++i) {
            const double moved = std::max((now.points[i] - before.points[i]).norm(),
                                          std::abs(now.length - before.length));
            most = std::max(most, moved / (to * kRadius * kStep));
          }
          before = std::move(now);
        }
      }
      EXPECT_LT(most, 12.0) << from << " " << to;
      // These steps adjoin, so no jump lies between them.
      double length = wrap_segment(a, Vec3(to * kRadius, 0.0, 0.0)).length;
      for (int k = 1; k <= 36000; ++k) {
        const double at = k * 0.01 * kDegree;
        const double now =
            wrap_segment(a, to * kRadius * Vec3(std::cos(at), std::sin(at), 0.0)).length;
        EXPECT_LT(std::abs(now - length), 12.0 * to * kRadius * 0.01 * kDegree) << at;
        length = now;
      }
    }
  }
}

// A point that two bodies share: it moves with the origin of its body and takes its share of a
// rotation of 90 degrees. It is continuous in the pose, also at 180 degrees, where the axis of the
// rotation changes sign.
TEST(Path, ASharedPointTakesItsShareOfATurn) {
  Pose rest(2, Transform::Identity()), pose;
  rest[0].linear() = rotation_about(Vec3(3, 1, 2).normalized(), 0.4);
  rest[1].linear() = rotation_about(Vec3(1, -1, 2).normalized(), 1.1);
  rest[1].translation() = Vec3(0.1, 0.2, 0.0);
  const Vec3 arm(0.0, -0.05, 0.0);
  PathPoint point{1, rest[1].linear().transpose() * arm};
  share_turn(0, 0.7, rest, point);
  const auto place = [&](const Vec3& axis, double angle) {
    pose = rest;
    pose[1].linear() = rotation_about(axis, angle) * rest[1].linear();
    pose[1].translation() += Vec3(0.0, 0.0, 0.01);
    return Vec3(frame_of_point(point, pose) * point.position);
  };
  const Vec3 joint(0.1, 0.2, 0.01);
  EXPECT_LT((place(Vec3::UnitX(), 0.0) - joint - arm).norm(), 1e-15);
  const Vec3 turned = rotation_about(Vec3::UnitX(), 63.0 * kDegree) * arm;
  EXPECT_LT((place(Vec3::UnitX(), 90.0 * kDegree) - joint - turned).norm(), 1e-15);
  // It moves with the other body.
  for (Transform& body : pose) body = Transform(Eigen::Translation3d(0.3, 0, 0)) * body;
  EXPECT_LT(
      (frame_of_point(point, pose) * point.position - Vec3(0.3, 0, 0) - joint - turned).norm(),
      1e-15);
  for (double degrees = -360.0; degrees < 360.0; degrees += 0.05) {
    const Vec3 axis = Vec3(1.0, 0.3, -0.2).normalized();
    const Vec3 now = place(axis, degrees * kDegree), next = place(axis, (degrees + 0.05) * kDegree);
    EXPECT_LT((next - now).norm(), 2.5 * 0.05 * kDegree * arm.norm()) << degrees;
  }
}

TEST(Path, PointWithinTheRadiusCountsAsOnTheSurface) {
  const Vec3 b(-0.05, -0.02, 0.01);
  const auto from = [&](double x) { return wrap_segment({x, 0, 0}, b).length; };
  EXPECT_NEAR(from(0.5 * kRadius), from(kRadius), 1e-16);
  EXPECT_NEAR(from(kRadius * (1 + 1e-10)), from(kRadius), 1e-10);
  EXPECT_TRUE(std::isfinite(from(0.0)));
  EXPECT_EQ(wrap_segment({0.5 * kRadius, 0, 0}, b).points.front(), Vec3(0.5 * kRadius, 0, 0));
}

TEST(Path, MomentArmOfAPulleyIsItsRadius) {
  // A cable over a pulley at the joint to a point that turns about it: |dL/dtheta| = radius.
  const MusclePath path{{{0, {-0.01, 0.3, 0}}, {1, {-0.01, -0.3, 0.02}}},
                        {{0, 0, Vec3::Zero(), Vec3::UnitZ(), kRadius, 1.0}}};
  const auto length = [&](double theta) {
    Pose pose(2, Transform::Identity());
    pose[1].linear() = rotation_about(Vec3::UnitZ(), theta);
    return trace_path(path, pose).length;
  };
  const double e = 1e-6;
  for (double theta : {0.5, 1.0, 2.0}) {
    // dz = 0.02 tilts the cable: the arm shrinks by the cosine of its slope.
    const double flat = std::sqrt(length(theta) * length(theta) - 0.02 * 0.02);
    EXPECT_NEAR((length(theta + e) - length(theta - e)) / (2 * e), kRadius * flat / length(theta),
                1e-9);
  }
}

TEST(Path, DoesNotDependOnTheWorldFrame) {
  const MusclePath path{{{0, {0.05, -0.03, 0}}, {1, {-0.04, -0.02, 0.03}}},
                        {{0, 0, {0, 0.001, 0}, {0.1, 0, 2.0}, kRadius, 1.0}}};
  Transform moved = Transform::Identity();
  moved.linear() = rotation_about(Vec3(1, 2, 3).normalized(), 1.1);
  moved.translation() = Vec3(1, -2, 0.5);
  const TracedPath here = trace_path(path, {Transform::Identity(), Transform::Identity()});
  const TracedPath there = trace_path(path, {moved, moved});
  EXPECT_NEAR(here.length, there.length, 1e-15);
  for (size_t i = 0; i < here.points.size(); ++i) {
    EXPECT_NEAR((moved * here.points[i] - there.points[i]).norm(), 0.0, 1e-15);
  }
}

// --- OpenSim's arm26 (opensim-org/opensim-models, Models/Arm26/arm26.osim, CC BY 3.0). Points in
// the humerus frame at rest: body 0 humerus with base, body 1 ulna.
const Vec3 kElbow(0.0061, -0.2904, -0.0123);
const Vec3 kElbowAxis = Vec3(0.04940001, 0.03660001, 0.99810825).normalized();
const Vec3 kBase(-0.017545, -0.007, 0.17);  // humerus = base + this

// WrapCylinder "TRI": body-fixed x-y-z rotation, axis local z.
WrapCylinder elbow_cylinder(int segment, double turn) {
  const Mat3 r = rotation_about(Vec3::UnitX(), -0.14015) *
                 rotation_about(Vec3::UnitY(), -0.00628319) *
                 rotation_about(Vec3::UnitZ(), 0.154985);
  return {segment, 0, {0.0028, -0.2919, -0.0069}, r.col(2), 0.016, turn};
}

MusclePath triceps(const std::vector<Vec3>& first) {
  MusclePath path;
  for (const Vec3& p : first) path.points.push_back({0, p});
  path.points.push_back({0, {-0.03184, -0.22637, -0.01217}});
  path.points.push_back({0, {-0.01743, -0.26757, -0.01208}});
  path.points.push_back({1, {-0.0219, 0.01046, -0.00078}});
  path.wraps = {elbow_cylinder(static_cast<int>(path.points.size()) - 2, 1.0)};
  return path;
}

MusclePath biceps(const std::vector<Vec3>& on_humerus) {
  MusclePath path;
  for (const Vec3& p : on_humerus) path.points.push_back({0, p});
  path.points.push_back({1, {0.00751, -0.04839, 0.02179}});
  return path;
}

MusclePath brachialis() {
  return {{{0, {0.0068, -0.1739, -0.0036}}, {1, {-0.0032, -0.0239, 0.0009}}},
          {elbow_cylinder(0, -1.0)}};
}

double length_at(const MusclePath& path, double degrees) {
  Pose pose(2, Transform::Identity());
  pose[1].translation() = kElbow;
  pose[1].linear() = rotation_about(kElbowAxis, degrees * kDegree);
  return trace_path(path, pose).length;
}

void expect_lengths(const MusclePath& path, const std::vector<double>& millimetres) {
  const double angles[] = {0, 30, 60, 90, 120, 130};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(1000.0 * length_at(path, angles[i]), millimetres[i], 1.0) << angles[i] << " deg";
  }
}

TEST(Arm26, TricepsLengths) {
  expect_lengths(
      triceps({Vec3(-0.05365, -0.01373, 0.14723) - kBase, {-0.02714, -0.11441, -0.00664}}),
      {277.6, 289.8, 301.8, 312.3, 322.7, 326.1});
  expect_lengths(triceps({{-0.00599, -0.12646, 0.00428}, {-0.02344, -0.14528, 0.00928}}),
                 {166.6, 178.8, 190.8, 201.3, 211.7, 215.1});
}

TEST(Arm26, BicepsLengths) {
  expect_lengths(biceps({Vec3(-0.039235, 0.00347, 0.14795) - kBase,
                         Vec3(-0.028945, 0.01391, 0.15639) - kBase,
                         {0.02131, 0.01793, 0.01028},
                         {0.02378, -0.00511, 0.01201},
                         {0.01345, -0.02827, 0.00136},
                         {0.01068, -0.07736, -0.00165},
                         {0.01703, -0.12125, 0.00024},
                         {0.0228, -0.1754, -0.0063}}),
                 {421.2, 411.7, 394.0, 370.3, 344.9, 337.3});
  expect_lengths(biceps({Vec3(0.004675, -0.01231, 0.13475) - kBase,
                         Vec3(-0.007075, -0.04004, 0.14507) - kBase,
                         {0.01117, -0.07576, -0.01101},
                         {0.01703, -0.12125, -0.01079},
                         {0.0228, -0.1754, -0.0063}}),
                 {341.7, 332.2, 314.5, 290.8, 265.4, 257.8});
}

// r = -dL/dtheta (cm), of the same model.
TEST(Arm26, MomentArms) {
  const MusclePath long_head =
      triceps({Vec3(-0.05365, -0.01373, 0.14723) - kBase, {-0.02714, -0.11441, -0.00664}});
  const double angles[] = {0, 30, 60, 90, 120, 130};
  const double back[] = {-2.01, -2.41, -2.12, -1.99, -1.97, -1.94};
  const double front[] = {1.51, 1.30, 1.67, 2.27, 2.35, 2.23};
  for (int i = 0; i < 6; ++i) {
    const auto arm = [&](const MusclePath& path) {
      const double e = 1e-3;  // degrees
      return -100.0 * (length_at(path, angles[i] + e) - length_at(path, angles[i] - e)) /
             (2 * e * kDegree);
    };
    EXPECT_NEAR(arm(long_head), back[i], 0.01) << angles[i] << " deg";
    EXPECT_NEAR(arm(brachialis()), front[i], 0.01) << angles[i] << " deg";
  }
}

// arm26 keeps the brachialis in front of the joint by a second point below 0.813 rad; the cylinder
// alone gives the same lengths.
TEST(Arm26, BrachialisLengths) {
  expect_lengths(brachialis(), {147.3, 140.0, 132.9, 122.4, 110.0, 106.0});
}

}  // namespace
}  // namespace thew::tests
