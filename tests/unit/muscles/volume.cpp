// SPDX-License-Identifier: Apache-2.0
#include "muscles/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

Points gradient_of(const Points& x, const std::vector<Triangle>& triangles) {
  Points gradient;
  volume_gradient(x, triangles, gradient);
  return gradient;
}

TEST(Volume, UnitCubeIsOneAndInsideOutMinusOne) {
  TriMesh cube = unit_cube();
  EXPECT_DOUBLE_EQ(enclosed_volume(to_points(cube.vertices), cube.triangles), 1.0);
  for (Triangle& t : cube.triangles) std::swap(t[0], t[1]);
  EXPECT_DOUBLE_EQ(enclosed_volume(to_points(cube.vertices), cube.triangles), -1.0);
  EXPECT_EQ(enclosed_volume(Points{}, {}), 0.0);
}

TEST(Volume, OriginDoesNotMatterEvenFarAway) {
  const TriMesh mesh = spindle();
  const Points x = to_points(mesh.vertices);
  const double volume = enclosed_volume(x, mesh.triangles);
  EXPECT_NEAR(volume, enclosed_volume(mesh),
              1e-14 * volume);  // that of rig, which is a separate implementation
  Points far(x);
  for (Point& row : far) row += Point{10.0, -10.0, 10.0, 0.0};
  EXPECT_NEAR(enclosed_volume(far, mesh.triangles), volume, 1e-12 * volume);
}

TEST(Volume, GradientIdentities) {
  const TriMesh mesh = spindle();
  const Points x = moved(to_points(mesh.vertices), 1.0, noise(mesh.vertices.size(), 0.002, 1));
  const Points g = gradient_of(x, mesh.triangles);
  const double volume = enclosed_volume(x, mesh.triangles);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (size_t i = 0; i < x.size(); ++i) {
    force += to_vec(g[i]);
    torque += to_vec(x[i]).cross(to_vec(g[i]));
    EXPECT_EQ(g[i][3], 0.0);
  }
  EXPECT_LT(force.norm(), 1e-17);   // m^2, beside 1e-2
  EXPECT_LT(torque.norm(), 1e-18);  // m^3
  EXPECT_NEAR(dot(x, g), 3.0 * volume, 1e-13 * volume);
}

TEST(Volume, GradientIsTheFiniteDifference) {
  const TriMesh mesh = spindle(7, 4);
  const Points x = moved(to_points(mesh.vertices), 1.0, noise(mesh.vertices.size(), 0.003, 2));
  const Points g = gradient_of(x, mesh.triangles);
  const double h = 1e-3;  // along one coordinate the volume is linear: no error of truncation
  for (size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      Points plus(x), minus(x);
      plus[i][k] += h;
      minus[i][k] -= h;
      const double slope =
          (enclosed_volume(plus, mesh.triangles) - enclosed_volume(minus, mesh.triangles)) /
          (2 * h);
      EXPECT_NEAR(g[i][k], slope, 1e-15);
    }
  }
}

TEST(Volume, CubicIsTheVolumeAtAnyStep) {
  const TriMesh mesh = spindle();
  const Points x = to_points(mesh.vertices), d = noise(x.size(), 0.01, 3);
  const VolumeCubic c = volume_along(x, d, mesh.triangles);
  EXPECT_EQ(c.c0, enclosed_volume(x, mesh.triangles));  // the same sum, so the same bytes
  EXPECT_NEAR(c.c1, dot(gradient_of(x, mesh.triangles), d), 1e-13 * c.c0);
  EXPECT_NEAR(c.c3, enclosed_volume(d, mesh.triangles), 1e-13 * c.c0);
  for (double s : {-2.0, -0.3, 0.1, 1.0, 5.0}) {
    const double volume = enclosed_volume(moved(x, s, d), mesh.triangles);
    EXPECT_NEAR(c.c0 + s * (c.c1 + s * (c.c2 + s * c.c3)), volume, 1e-12 * c.c0);
  }
}

TEST(Volume, CubeGrowsAsTheCubeOfItsSide) {
  const TriMesh cube = unit_cube();
  const Points x = to_points(cube.vertices);
  const VolumeCubic c = volume_along(x, x, cube.triangles);  // (1 + s)^3
  EXPECT_DOUBLE_EQ(c.c0, 1.0);
  EXPECT_DOUBLE_EQ(c.c1, 3.0);
  EXPECT_DOUBLE_EQ(c.c2, 3.0);
  EXPECT_DOUBLE_EQ(c.c3, 1.0);
  const VolumeRoot root = nearest_root(c, 8.0);
  EXPECT_TRUE(root.reached);
  EXPECT_DOUBLE_EQ(root.s, 1.0);
}

struct RootCase {
  VolumeCubic cubic;
  double target, s;
  bool reached;
};

// The discriminant of its derivative overflows; the search for a bracket must still end.
TEST(NearestRoot, EndsWhateverTheCoefficients) {
  const double kFar[] = {-1e300, -1e200, -1.0, 0.0, 5e-324, 1e-200, 1.0, 1e200, 1e300};
  for (const double c0 : kFar) {
    for (const double c1 : kFar) {
      for (const double c2 : kFar) {
        for (const double c3 : kFar) {
          const VolumeRoot root = nearest_root({c0, c1, c2, c3}, 1.0);
          EXPECT_FALSE(root.reached && !std::isfinite(root.s))
              << c0 << " " << c1 << " " << c2 << " " << c3;
        }
      }
    }
  }
}

TEST(VolumeRoot, KnownCases) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const auto& [cubic, target, s, reached] : {
           RootCase{{1, 1, 0, 0}, 1, 0, true},      // there already
           RootCase{{1, 2, 0, 0}, 2, 0.5, true},    // linear
           RootCase{{1, -2, 0, 0}, 2, -0.5, true},  //
           RootCase{{0, -3, 1, 0}, -2, 1, true},    // s^2 - 3 s + 2: the nearer of 1 and 2
           RootCase{{-6, 11, -6, 1}, 0, 1, true},   // (s - 1)(s - 2)(s - 3)
           RootCase{{6, 11, 6, 1}, 0, -1, true},    // mirrored
           RootCase{{1, -2, 1, 0}, 0, 1, true},     // double root (s - 1)^2
           RootCase{{2, -5, 4, -1}, 0, 1, true},    // (s - 1)^2 (2 - s)
           RootCase{{0, 0, 0, 1}, 8, 2, true},      // no slope at 0
           RootCase{{0, 0, 0, -1}, 8, -2, true},    //
           RootCase{{0, 0, 1, 0}, 4, 2, true},      // either side does
           RootCase{{0, 0, 1, 0}, -4, 0, false},    // leads away on both
           RootCase{{1, -2, 1, 0}, -1, 1, false},   // parabola that stays above
           RootCase{{1, -3, 0, 1}, -2, 1, false},   // s^3 - 3 s + 1: 1 is as low as it gets
           RootCase{{1, 0, 0, 0}, 2, 0, false},     // flat: nothing moves
           RootCase{{1, 0, 0, 0}, 1, 0, true},      //
           RootCase{{NAN, 1, 0, 0}, 1, 0, false},   // never an endless loop
           RootCase{{1, inf, 0, 0}, 2, 0, false},
       }) {
    const VolumeRoot root = nearest_root(cubic, target);
    EXPECT_EQ(root.reached, reached) << cubic.c0 << " " << cubic.c1 << " " << cubic.c2;
    EXPECT_NEAR(root.s, s, 3e-8) << cubic.c0 << " " << cubic.c1 << " " << cubic.c2;
  }
}

TEST(VolumeRoot, ToRoundingErrorForAnySizeOfTheNumbers) {
  for (double volume : {1e-15, 1e-4, 1.0, 1e9}) {
    for (double step : {1e-9, 1.0, 1e9}) {
      for (double change : {-0.3, -1e-7, 1e-12, 0.01, 0.5}) {
        const double a = 1.0 / step;
        const VolumeCubic c{volume, 2.5 * volume * a, 1.7 * volume * a * a,
                            0.3 * volume * a * a * a};
        const double target = volume * (1.0 + change);
        const VolumeRoot root = nearest_root(c, target);
        ASSERT_TRUE(root.reached);
        const double s = root.s;
        EXPECT_LE(std::fabs(c.c0 + s * (c.c1 + s * (c.c2 + s * c.c3)) - target), 5e-16 * target);
      }
    }
  }
}

}  // namespace
}  // namespace thew::tests
