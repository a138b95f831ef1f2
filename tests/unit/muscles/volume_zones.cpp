// SPDX-License-Identifier: Apache-2.0
#include "muscles/volume_zones.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "muscles/volume.h"
#include "rig/math.h"
#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

constexpr double kLength = 0.15;  // m, of the spindle along y

std::vector<double> along_y(const TriMesh& mesh) {
  std::vector<double> along;
  for (const Vec3& p : mesh.vertices) along.push_back(p.y() / kLength);
  return along;
}
VolumeZones zones_of(const TriMesh& mesh, int count) {
  return make_volume_zones(mesh, along_y(mesh), count);
}

std::vector<double> before_of(const VolumeZones& zones, const Points& x, const TriMesh& mesh) {
  std::vector<double> before;
  volumes_before(zones, x, mesh.triangles, before);
  return before;
}

Points mapped(const Points& x, const std::function<Vec3(const Vec3&)>& map) {
  Points out;
  for (const Point& row : x) out.push_back(to_point(map(to_vec(row))));
  return out;
}

// Bends the body into half a circle; the axis keeps its length.
Vec3 bend(const Vec3& p) {
  const double radius = kLength / kPi, angle = kPi * p.y() / kLength;
  return {(radius + p.x()) * std::cos(angle), (radius + p.x()) * std::sin(angle), p.z()};
}

TEST(VolumeZones, EvenPrismIsCutIntoEvenParts) {
  TriMesh box = unit_cube();  // 4 x 1 x 1, four times as fine
  for (Vec3& p : box.vertices) p.x() *= 4.0;
  box = subdivided(subdivided(subdivided(box)));
  const std::vector<double> along = longest_axis_coordinates(box);
  for (size_t i = 0; i < along.size(); ++i) EXPECT_NEAR(along[i], box.vertices[i].x() / 4.0, 1e-12);
  for (int count : {2, 4, 8}) {
    const VolumeZones zones = make_volume_zones(box, along, count);
    EXPECT_EQ(zones.count(), count);
    for (int j = 0; j < count; ++j) {
      EXPECT_NEAR(zones.rest_before[j], 4.0 * (j + 1) / count, 1e-3) << count;
    }
  }
}

// In any shape the last volume is the whole, and each zone keeps its share of that of the straight
// shape.
TEST(VolumeZones, SumToTheWholeHoweverBent) {
  const TriMesh mesh = spindle(24, 31);
  const VolumeZones zones = zones_of(mesh, 4);
  const Points rest = to_points(mesh.vertices), bent = mapped(rest, bend);
  EXPECT_EQ(before_of(zones, rest, mesh), zones.rest_before);
  EXPECT_EQ(zones.rest_before.back(), enclosed_volume(rest, mesh.triangles));
  const std::vector<double> before = before_of(zones, bent, mesh);
  EXPECT_EQ(before.back(), enclosed_volume(bent, mesh.triangles));
  for (size_t j = 0; j < before.size(); ++j) {  // Pappus: bending about the centroid keeps volumes
    EXPECT_NEAR(before[j], zones.rest_before[j], 0.01 * before.back());
  }
}

TEST(VolumeZones, RigidMotionLeavesThemAsTheyAre) {
  const TriMesh mesh = spindle();
  const VolumeZones zones = zones_of(mesh, 5);
  const Points x = moved(to_points(mesh.vertices), 1.0, noise(mesh.vertices.size(), 0.003, 11));
  const Mat3 turn = rotation_about(Vec3(0.3, -0.4, 0.5).normalized(), 2.1);
  const Points there =
      mapped(x, [&](const Vec3& p) -> Vec3 { return turn * p + Vec3(0.4, -0.2, 0.7); });
  const std::vector<double> a = before_of(zones, x, mesh), b = before_of(zones, there, mesh);
  for (size_t j = 0; j < a.size(); ++j) EXPECT_NEAR(a[j], b[j], 1e-13 * a.back());
  // So no zone's gradient has a net force or torque.
  std::vector<Points> gradients;
  gradients_before(zones, x, mesh.triangles, gradients);
  for (const Points& gradient : gradients) {
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (size_t i = 0; i < x.size(); ++i) {
      force += to_vec(gradient[i]);
      torque += to_vec(x[i]).cross(to_vec(gradient[i]));
    }
    EXPECT_LT(force.norm(), 1e-17);   // m^2, beside 1e-3
    EXPECT_LT(torque.norm(), 1e-18);  // m^3
  }
}

TEST(VolumeZones, GradientsAreTheFiniteDifferences) {
  const TriMesh mesh = spindle(8, 9);
  const VolumeZones zones = zones_of(mesh, 4);
  const Points x = moved(to_points(mesh.vertices), 1.0, noise(mesh.vertices.size(), 0.003, 12));
  std::vector<Points> gradients;
  gradients_before(zones, x, mesh.triangles, gradients);
  ASSERT_EQ(gradients.size(), 4u);
  const double h = 1e-6;  // a cubic along a node of the section
  for (size_t i = 0; i < x.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      Points plus(x), minus(x);
      plus[i][k] += h;
      minus[i][k] -= h;
      const std::vector<double> high = before_of(zones, plus, mesh);
      const std::vector<double> low = before_of(zones, minus, mesh);
      for (size_t c = 0; c < gradients.size(); ++c) {
        EXPECT_NEAR(gradients[c][i][k], (high[c] - low[c]) / (2 * h), 1e-13) << c << " " << i;
      }
    }
  }
}

struct Restored {
  bool reached;
  Points x;
  double error;  // of a zone
};
// From a shape `squeezed` out of the rest shape, along the gradients there; `free` nodes move.
Restored restore(const TriMesh& mesh, const VolumeZones& zones, const Points& squeezed,
                 const std::function<double(size_t)>& freedom) {
  std::vector<Points> directions;
  gradients_before(zones, squeezed, mesh.triangles, directions);
  for (Points& direction : directions) {
    for (size_t i = 0; i < direction.size(); ++i) direction[i] *= freedom(i);
  }
  ZoneScratch scratch;
  Restored out{false, squeezed, 0.0};
  out.reached = restore_zones(zones, mesh.triangles, zones.rest_before, directions, scratch, out.x);
  out.error = zone_error(zones, before_of(zones, out.x, mesh), zones.rest_before);
  return out;
}

// Half of the length is flattened to 60 %, so that volume would flow to the other half.
Points flattened(const TriMesh& mesh) {
  return mapped(to_points(mesh.vertices), [](const Vec3& p) {
    return p.y() < 0.5 * kLength ? Vec3(0.6 * p.x(), p.y(), p.z()) : p;
  });
}

TEST(VolumeZones, NewtonHoldsEachZoneToRounding) {
  const TriMesh mesh = spindle(16, 33);
  for (int count : {2, 3, 4, 8, 16}) {
    const VolumeZones zones = zones_of(mesh, count);
    const Points squeezed = flattened(mesh);
    EXPECT_GT(zone_error(zones, before_of(zones, squeezed, mesh), zones.rest_before), 0.2);
    const Restored all = restore(mesh, zones, squeezed, [](size_t) { return 1.0; });
    EXPECT_TRUE(all.reached) << count;
    EXPECT_LE(all.error, 1e-11) << count;
    EXPECT_NEAR(enclosed_volume(all.x, mesh.triangles) / zones.rest_before.back(), 1.0, 2e-13);
  }
  // One multiplier restores the whole volume, but not that of the zones.
  const VolumeZones zones = zones_of(mesh, 4);
  Points x = flattened(mesh), gradient;
  volume_gradient(x, mesh.triangles, gradient);
  const VolumeRoot root =
      nearest_root(volume_along(x, gradient, mesh.triangles), zones.rest_before.back());
  const Points one = moved(x, root.s, gradient);
  EXPECT_GT(zone_error(zones, before_of(zones, one, mesh), zones.rest_before), 0.1);
}

void expect_left_alone(const Restored& found, const Points& before) {
  EXPECT_FALSE(found.reached);
  for (size_t i = 0; i < before.size(); ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(found.x[i][k], before[i][k]);
  }
}

TEST(VolumeZones, WhatCannotBeReachedIsLeftAlone) {
  const TriMesh mesh = spindle(16, 33);
  const VolumeZones zones = zones_of(mesh, 4);
  const Points squeezed = flattened(mesh);
  // Weights of zero in a zone, and in all of them.
  const auto second_half = [&](size_t i) {
    return mesh.vertices[i].y() > 0.76 * kLength ? 1.0 : 0.0;
  };
  expect_left_alone(restore(mesh, zones, squeezed, second_half), squeezed);
  expect_left_alone(restore(mesh, zones, squeezed, [](size_t) { return 0.0; }), squeezed);
  // A zone that cannot move does not matter if its volume is right already.
  const auto first_half = [&](size_t i) {
    return mesh.vertices[i].y() < 0.74 * kLength ? 1.0 : 0.0;
  };
  EXPECT_TRUE(restore(mesh, zones_of(mesh, 16), squeezed, first_half).reached);
  // All nodes of a zone in one point, of all zones, and one that is nowhere.
  const Vec3 point(0, 0.1 * kLength, 0);
  const auto collapsed = [&](double until) {
    return mapped(to_points(mesh.vertices),
                  [&](const Vec3& p) { return p.y() < until * kLength ? point : p; });
  };
  for (double until : {0.4, 1.1}) {
    const Points x = collapsed(until);
    expect_left_alone(restore(mesh, zones, x, [](size_t) { return 1.0; }), x);
  }
  Points nowhere = squeezed;
  nowhere[40][1] = std::numeric_limits<double>::quiet_NaN();
  const Restored lost = restore(mesh, zones, nowhere, [](size_t) { return 1.0; });
  EXPECT_FALSE(lost.reached);
  EXPECT_EQ(lost.x[41][1], nowhere[41][1]);
}

TEST(VolumeZones, TooManyAreRefused) {
  const auto message = [](const TriMesh& mesh, int count) -> std::string {
    try {
      zones_of(mesh, count);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(spindle(8, 15), 4), "");
  EXPECT_NE(message(spindle(8, 3), 8).find("no node lies near the cut between zones"),
            std::string::npos);
  TriMesh flat = spindle(8, 15);  // its first zone is a sheet without volume
  for (Vec3& p : flat.vertices) p.z() *= p.y() < 0.4 * kLength ? 0.0 : 1.0;
  EXPECT_NE(message(flat, 4).find("zone 1 of 4 holds next to no volume"), std::string::npos);
}

TEST(VolumeZones, TheLongestAxisIsFoundHoweverItLies) {
  TriMesh mesh = spindle();
  const Mat3 turn = rotation_about(Vec3(1, 2, 3).normalized(), 0.4);
  for (Vec3& p : mesh.vertices) p = turn * p;
  const std::vector<double> along = longest_axis_coordinates(mesh);
  for (size_t i = 0; i < along.size(); ++i) {
    EXPECT_NEAR(along[i], spindle().vertices[i].y() / kLength, 1e-12);
  }
}

}  // namespace
}  // namespace thew::tests
