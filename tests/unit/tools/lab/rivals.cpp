// SPDX-License-Identifier: Apache-2.0
//
// Each method of others against a fact that its own authors state.
#include <gtest/gtest.h>

#include <cmath>

#include "muscles/volume.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/shapes.h"
#include "tools/lab/rivals/aubel.h"
#include "tools/lab/rivals/bourguignon.h"
#include "tools/lab/rivals/chen_zeltzer.h"
#include "tools/lab/rivals/descent.h"
#include "tools/lab/rivals/hirota.h"
#include "tools/lab/rivals/nedel.h"
#include "tools/lab/rivals/promayon.h"
#include "tools/lab/rivals/scheepers.h"
#include "tools/lab/rivals/zordan.h"

namespace thew::tests {
namespace {

TriMesh small_ball(int triangles = 300) {
  TriMesh mesh = paper_ball(triangles);
  for (Vec3& p : mesh.vertices) p *= 0.1;
  return mesh;
}

RivalBody small_solid(int tetrahedra = 900) {
  return solid_body(fill_ball(small_ball(), tetrahedra), 1060.0);
}

void deform(const Mat3& f, RivalBody& body) {
  for (size_t i = 0; i < body.x.size(); ++i) body.x[i] = to_point(f * body.rest[i]);
}

Mat3 squashed(double along_y) { return Vec3(1.0, along_y, 1.0).asDiagonal(); }

Surroundings planes(double height) {
  Surroundings around;
  around.beyond = [height](double, const Vec3& p) {
    const double depth = std::abs(p.y()) - height;
    return Vec3(0, depth > 0.0 ? std::copysign(depth, p.y()) : 0.0, 0);
  };
  return around;
}

// |V/V0 - 1| of the ball after a second between planes that have closed by `travel` (m) each.
double error_of(RivalBody body, const Stepper& step, int steps, double travel = 0.02) {
  const double rest = volume_of(body), h = 1.0 / steps;
  for (int k = 1; k <= steps; ++k) step(planes(0.1 - travel * k / steps), k * h, h, body);
  return std::abs(volume_of(body) / rest - 1.0);
}

// "The volume can be kept exactly constant during deformation without an iterative process."
TEST(Promayon, OneProjectionRestoresTheVolumeExactly) {
  RivalBody body = surface_body(small_ball(), 1060.0);
  const double rest = volume_of(body);
  const Stepper step = promayon_stepper(body, 0.0, false);
  deform(squashed(0.7), body);
  step({}, 1e-4, 1e-4, body);
  EXPECT_NEAR(volume_of(body) / rest, 1.0, 1e-13);
  double fastest = 0.0;  // the projection is in no velocity: only 1e-4 s of springs is
  for (const Point& v : body.v) fastest = std::max(fastest, std::sqrt(dot(v, v)));
  EXPECT_LT(fastest * 1e-4, 1e-3 * 0.1);
}

TEST(Promayon, KeepsItBetweenPlanes) {
  const RivalBody body = surface_body(small_ball(), 1060.0);
  EXPECT_LT(error_of(body, promayon_stepper(body, 2.0, true), 1000), 1e-10);
}

// The lungs' pressure: what is missing of the volume pushes along the normals, and the stiffer the
// less is missing.
TEST(Zordan, PressurePushesAlongNormalsAndTheStifferTheBetter) {
  RivalBody body = surface_body(small_ball(), 1060.0);
  const Stepper none = zordan_stepper(body, 0.0, 0.0), step = zordan_stepper(body, 0.0, 1e4);
  RivalBody free = body;
  deform(squashed(0.9), body);
  deform(squashed(0.9), free);
  step({}, 1e-4, 1e-4, body);
  none({}, 1e-4, 1e-4, free);
  Points gradient;
  deform(squashed(0.9), free);
  volume_gradient(free.x, free.triangles, gradient);
  for (size_t i = 0; i < body.x.size(); ++i) {
    const Point push = body.mass[i] / 1e-4 * (body.v[i] - free.v[i]);
    // p = 1e4 * 0.1 Pa
    EXPECT_NEAR((to_vec(push) - 1e3 * to_vec(gradient[i])).norm(), 0.0, 1e-6);
  }
  const RivalBody rest = surface_body(small_ball(), 1060.0);
  const double soft = error_of(rest, zordan_stepper(rest, 2.0, 1e4), 4000);
  const double hard = error_of(rest, zordan_stepper(rest, 2.0, 1e5), 4000);
  EXPECT_LT(hard, 0.2 * soft);
}

// "Angular springs ... were developed to control the muscle volume."
TEST(Nedel, AngularSpringsLoseLessVolumeAndAreATrueGradient) {
  const RivalBody rest = surface_body(small_ball(), 1060.0);
  const double without = error_of(rest, nedel_stepper(rest, 2.0, 0.0), 1000, 0.05);
  EXPECT_LT(error_of(rest, nedel_stepper(rest, 2.0, 1e-3), 1000, 0.05), 0.75 * without);
  const std::vector<AngularSpring> springs = angular_springs(rest);
  Points f(rest.x.size(), Point{});
  add_angular_forces(springs, 1.0, rest.x, f);
  for (const Point& force : f) EXPECT_LT(std::sqrt(dot(force, force)), 1e-9);
  // One spring by differences.
  const std::vector<AngularSpring> one = {{0, 1, 2, 0.5}};
  const Points x = to_points({{0, 0, 0}, {1, 0.2, 0.1}, {-0.3, 0.9, 0.2}});
  const auto energy = [&](const Points& p) {
    const Vec3 a = to_vec(p[1] - p[0]), b = to_vec(p[2] - p[0]);
    const double off = std::acos(a.normalized().dot(b.normalized())) - 0.5;
    return 0.5 * off * off;
  };
  Points force(3, Point{});
  add_angular_forces(one, 1.0, x, force);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      Points up = x, down = x;
      up[i][k] += 1e-6;
      down[i][k] -= 1e-6;
      EXPECT_NEAR(force[i][k], -(energy(up) - energy(down)) / 2e-6, 1e-7);
    }
  }
}

// "It contrasts with those systems in its ability to model constant volume deformations": with the
// soft constraint less volume is lost. And what is printed does not balance within an element.
TEST(Bourguignon, BarycentreSpringsLoseLessVolume) {
  const RivalBody rest = small_solid();
  const double without = error_of(rest, bourguignon_stepper(rest, 2.0, 3000.0, 0.0), 1000);
  EXPECT_LT(error_of(rest, bourguignon_stepper(rest, 2.0, 3000.0, 100.0), 1000), 0.7 * without);
  RivalBody body = rest;
  BarycentreSprings soft = barycentre_springs(body, 100.0);
  Points f(body.x.size(), Point{});
  add_barycentre_forces(soft, body, f);
  for (const Point& force : f) EXPECT_LT(std::sqrt(dot(force, force)), 1e-10);
  Mat3 shear = squashed(0.8);
  shear(0, 1) = 0.3;
  deform(shear, body);
  for (const bool balanced : {false, true}) {
    soft.balanced = balanced;
    f.assign(f.size(), Point{});
    add_barycentre_forces(soft, body, f);
    Vec3 sum = Vec3::Zero();
    double size = 0.0;
    for (const Point& force : f) {
      sum += to_vec(force);
      size += to_vec(force).norm();
    }
    EXPECT_EQ(sum.norm() < 1e-12 * size, balanced) << sum.norm() / size;
  }
}

// "The volume of the object is preserved": to the penalty's tolerance, under a strong deformation.
TEST(Hirota, TheLatticeKeepsTheVolumeUpToItsPenalty) {
  const RivalBody rest = surface_body(small_ball(), 1060.0);
  LatticeSetting setting;
  setting.cells = 4;
  setting.modulus = 0.0;
  const double without = error_of(rest, hirota_stepper(rest, setting), 4);
  setting.modulus = 1e6;
  const double with = error_of(rest, hirota_stepper(rest, setting), 4);
  EXPECT_GT(without, 0.02);
  EXPECT_LT(with, 1e-3);
}

TEST(Hirota, TheEnergysGradientIsRight) {
  RivalBody body = surface_body(small_ball(60), 1060.0);
  LatticeSetting setting;
  setting.cells = 2;
  const Lattice lattice = make_lattice(body, setting);
  std::vector<double> control, gradient, scratch;
  for (const Vec3& p : lattice.rest) {
    const Vec3 q = squashed(0.7) * p + 0.3 * p.x() * Vec3(0, p.z(), p.y());
    control.insert(control.end(), q.data(), q.data() + 3);
  }
  const auto beyond = [](const Vec3& p) { return planes(0.06).beyond(0.0, p); };
  Points x;
  lattice_energy(lattice, body, beyond, body.x, control, x, &gradient);
  for (size_t k = 0; k < control.size(); k += 7) {
    std::vector<double> up = control, down = control;
    up[k] += 1e-6;
    down[k] -= 1e-6;
    const double slope = (lattice_energy(lattice, body, beyond, body.x, up, x, nullptr) -
                          lattice_energy(lattice, body, beyond, body.x, down, x, nullptr)) /
                         2e-6;
    EXPECT_NEAR(gradient[k], slope, 1e-4 * (1.0 + std::abs(slope)));
  }
}

// Turned without strain, warped elements feel nothing, linear ones do; and the forces of each
// element cancel, which warping node by node (2002) did not give.
TEST(Warped, ATurnedBodyFeelsNothingAndForcesCancel) {
  const RivalBody rest = small_solid();
  FemBody body = elements_of(rest, {.shear = 1000.0, .lambda = 1e4, .penalty = 0.0});
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  WarpedForces turned, linear;
  for (size_t i = 0; i < body.x.size(); ++i) body.x[i] = turn * body.rest[i];
  warped_forces(body, true, turned);
  warped_forces(body, false, linear);
  EXPECT_LT(turned.f.norm(), 1e-10 * linear.f.norm());
  for (size_t i = 0; i < body.x.size(); ++i) {
    const Vec3& p = body.rest[i];
    body.x[i] = turn * (p + 3.0 * p.y() * Vec3(p.y(), 0.5 * p.z(), p.x()));
  }
  warped_forces(body, true, turned);
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < body.x.size(); ++i) sum += turned.f.segment<3>(3 * i);
  EXPECT_LT(sum.norm(), 1e-11 * turned.f.norm());
}

// Stable: it is at rest at rest, and comes back from what has been flattened; by either solver,
// though a flattened body's matrix is not positive.
TEST(StableNeoHookean, ComesBackFromAFlattenedBody) {
  for (const bool direct : {true, false}) {
    RivalBody body = small_solid();
    const double rest = volume_of(body);
    const Stepper step = element_stepper(
        body, {{.neo_hookean = true, .shear = 1000.0, .penalty = 1e4}, 20.0, 30, direct});
    step({}, 0.01, 0.01, body);
    for (size_t i = 0; i < body.x.size(); ++i) {
      ASSERT_LT((to_vec(body.x[i]) - body.rest[i]).norm(), 1e-9);
    }
    deform(squashed(0.0), body);
    // A flat body knows no up: one node shows it.
    for (size_t i = 0; i < body.x.size(); ++i) body.x[i][1] += 1e-4 * body.rest[i].y();
    for (int k = 1; k <= 100; ++k) step({}, 0.05 * k, 0.05, body);
    EXPECT_NEAR(volume_of(body) / rest, 1.0, 1e-2) << direct;
  }
}

// "Each step is guaranteed to reduce the variational energy", and what it converges to is implicit
// Euler, which the finite elements solve by Newton.
TEST(VertexBlockDescent, EveryPassDescendsAndTheLimitIsImplicitEuler) {
  RivalBody body = small_solid(), other = body;
  const FemMaterial material{.neo_hookean = true, .shear = 1000.0, .penalty = 1e4};
  const double h = 1.0 / 120.0;
  Mat3 f = squashed(0.8);
  f(0, 1) = 0.2;
  deform(f, body);
  deform(f, other);
  const DescentBody descent = descent_body(body, material);
  const Points start = body.x;
  const std::function<Vec3(const Vec3&)> beyond;
  double before = descent_energy(descent, body, start, start, h, 0.0);
  for (int pass = 0; pass < 600; ++pass) {
    descend({descent, beyond, start, start, h, 0.0}, body);
    const double after = descent_energy(descent, body, start, start, h, 0.0);
    ASSERT_LE(after, before + 1e-12 * std::abs(before));
    before = after;
  }
  element_stepper(other, {material, 0.0, 50, true})({}, h, h, other);
  double apart = 0.0, way = 0.0;
  for (size_t i = 0; i < body.x.size(); ++i) {
    apart = std::max(apart, to_vec(body.x[i] - other.x[i]).norm());
    way = std::max(way, to_vec(body.x[i] - start[i]).norm());
  }
  EXPECT_LT(apart, 2e-3 * way);
}

// Hill's curve: most force at rest length, none at half and one and a half of it; a muscle held at
// both ends pulls on them, one that is free shortens and bulges.
TEST(ChenZeltzer, FibresPullAsHillsCurveSays) {
  EXPECT_DOUBLE_EQ(hill_force_length(1.0), 1.0);
  EXPECT_DOUBLE_EQ(hill_force_length(0.5), 0.0);
  EXPECT_DOUBLE_EQ(hill_force_length(1.5), 0.0);
  EXPECT_LT(hill_force_length(0.8), 1.0);
  RivalBody body = small_solid();
  const FemMaterial material{.shear = 1000.0, .lambda = 1e4, .penalty = 0.0};
  // Held: the force through the middle is stress times area.
  const FemBody held = elements_of(body, material);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(body.x.size()));
  add_fibre_forces({500.0, 1.0}, held, f);
  double moment = 0.0;  // sum of x f = -stress times volume
  for (size_t i = 0; i < body.x.size(); ++i) moment += body.rest[i].x() * f[3 * i];
  EXPECT_NEAR(moment, -500.0 * volume_of(body), 1e-9);
  const Stepper step = chen_zeltzer_stepper(body, material, 20.0, {500.0, 1.0});
  for (int k = 1; k <= 60; ++k) step({}, 0.02 * k, 0.02, body);
  Vec3 half = Vec3::Zero();
  for (const Point& p : body.x) half = half.cwiseMax(to_vec(p).cwiseAbs());
  EXPECT_LT(half.x(), 0.095);
  EXPECT_GT(half.y(), 0.1015);
}

// The ellipsoid's volume and the ratio of its short axes stay as it shortens.
TEST(Scheepers, VolumeAndRatioStay) {
  for (const double c : {0.05, 0.1, 0.2}) {
    const Vec3 axes = scheepers_axes(1e-4, 1.5, c);
    EXPECT_NEAR(4.0 / 3.0 * 3.14159265358979 * axes.prod(), 1e-4, 1e-15);
    EXPECT_NEAR(axes.x() / axes.y(), 1.5, 1e-12);
  }
}

TEST(Aubel, TheBellysVolumeStaysAsItShortens) {
  for (const double length : {0.1, 0.15, 0.3}) {
    const double wider = aubel_widening(0.2, length);
    EXPECT_NEAR(wider * wider * length, 0.2, 1e-15);
  }
}

}  // namespace
}  // namespace thew::tests
