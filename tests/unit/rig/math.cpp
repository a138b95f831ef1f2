// SPDX-License-Identifier: Apache-2.0
#include "rig/math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace thew::tests {
namespace {

TEST(SinCos, FactsAChildCanCheck) {
  EXPECT_EQ(sin_cos(0.0).sin, 0.0);
  EXPECT_EQ(sin_cos(0.0).cos, 1.0);
  EXPECT_EQ(sin_cos(kPi / 2.0).sin, 1.0);
  EXPECT_EQ(sin_cos(kPi).cos, -1.0);
  EXPECT_NEAR(sin_cos(30.0 * kDegree).sin, 0.5, 2e-16);
  EXPECT_NEAR(sin_cos(60.0 * kDegree).cos, 0.5, 2e-16);
}

TEST(SinCos, AgreesWithLongDouble) {
  for (int i = -200000; i <= 200000; ++i) {
    const double angle = i * 0.4999 + 1e-7 * i * i;  // to about 1e5 rad, all quadrants
    if (std::fabs(angle) >= 1e5) continue;
    const SinCos ours = sin_cos(angle);
    ASSERT_LT(std::fabs(static_cast<double>(ours.sin - sinl(angle))), 2e-16) << angle;
    ASSERT_LT(std::fabs(static_cast<double>(ours.cos - cosl(angle))), 2e-16) << angle;
  }
}

TEST(SinCos, KeepsSmallAnglesAndSymmetry) {
  for (double angle = 1e-300; angle < 1.0; angle *= 1.7) {
    EXPECT_NEAR(sin_cos(angle).sin / std::sin(angle), 1.0, 3e-16) << angle;
    EXPECT_EQ(sin_cos(-angle).sin, -sin_cos(angle).sin);
    EXPECT_EQ(sin_cos(-angle).cos, sin_cos(angle).cos);
  }
}

TEST(SinCos, NotFiniteGivesNan) {
  EXPECT_TRUE(std::isnan(sin_cos(std::numeric_limits<double>::infinity()).sin));
  EXPECT_TRUE(std::isnan(sin_cos(std::nan("")).cos));
}

// FNV-1a over the results: one number for every compiler, optimisation and processor.
TEST(SinCos, SameBytesEverywhere) {
  uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&](double value) {
    uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3u;
  };
  for (int i = -5000; i <= 5000; ++i) {
    const SinCos s = sin_cos(i * 0.0371);
    mix(s.sin);
    mix(s.cos);
    mix(arc_tan2(i * 0.25, 300.0 - i));
  }
  EXPECT_EQ(hash, 1682397585479576069u);
}

TEST(ArcTan2, QuadrantsAndAxes) {
  EXPECT_EQ(arc_tan2(0.0, 0.0), 0.0);
  EXPECT_EQ(arc_tan2(0.0, 1.0), 0.0);
  EXPECT_EQ(arc_tan2(1.0, 0.0), kPi / 2.0);
  EXPECT_EQ(arc_tan2(-1.0, 0.0), -kPi / 2.0);
  EXPECT_EQ(arc_tan2(0.0, -1.0), kPi);
  EXPECT_EQ(arc_tan2(-0.0, -1.0), kPi);  // in (-pi, pi]
  EXPECT_NEAR(arc_tan2(1.0, 1.0), kPi / 4.0, 1e-16);
  EXPECT_NEAR(arc_tan2(-1.0, -1.0), -3.0 * kPi / 4.0, 1e-15);
}

TEST(ArcTan2, AgreesWithLongDouble) {
  for (int i = 0; i < 200000; ++i) {
    const double angle = -kPi + i * (2.0 * kPi / 200000.0);
    const double scale = std::ldexp(1.0, i % 600 - 300);
    const double y = scale * std::sin(angle), x = scale * std::cos(angle);
    ASSERT_LT(std::fabs(static_cast<double>(arc_tan2(y, x) - atan2l(y, x))), 1e-15)
        << y << " " << x;
  }
  EXPECT_NEAR(arc_tan2(1e300, 1e300), kPi / 4.0, 1e-16);
  EXPECT_EQ(arc_tan2(1e-200, 1.0), 1e-200);
}

TEST(RotationAbout, QuarterTurns) {
  const Vec3 turned = rotation_about(Vec3::UnitZ(), kPi / 2.0) * Vec3::UnitX();
  EXPECT_LT((turned - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((rotation_about(Vec3::UnitX(), kPi / 2.0) * Vec3::UnitY() - Vec3::UnitZ()).norm(),
            1e-15);
  EXPECT_EQ(rotation_about(Vec3::UnitY(), 0.0), Mat3(Mat3::Identity()));
}

TEST(RotationAbout, AgreesWithEigenAndIsOrthonormal) {
  for (int i = 0; i < 100; ++i) {
    const Vec3 axis = Vec3(1.0 + i, 2.0 - i, 0.3 * i).normalized();
    const double angle = 0.37 * i - 15.0;
    const Mat3 r = rotation_about(axis, angle);
    EXPECT_LT((r - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((r * r.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(r.determinant(), 1.0, 1e-14);
  }
}

TEST(Smoothstep, EndsMiddleAndSlope) {
  EXPECT_EQ(smoothstep(1.0, 3.0, 0.5), 0.0);
  EXPECT_EQ(smoothstep(1.0, 3.0, 2.0), 0.5);
  EXPECT_EQ(smoothstep(1.0, 3.0, 3.5), 1.0);
  EXPECT_NEAR(smoothstep(1.0, 3.0, 1.0 + 1e-6), 0.0, 1e-11);
  EXPECT_NEAR(smoothstep(1.0, 3.0, 3.0 - 1e-6), 1.0, 1e-11);
}

}  // namespace
}  // namespace thew::tests
