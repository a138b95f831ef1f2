// SPDX-License-Identifier: Apache-2.0
#include "muscles/springs.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

TEST(Springs, CubeHasEighteenEdgesAndAsManyOppositePairs) {
  const Springs springs = make_springs(unit_cube(), {}, {});
  EXPECT_EQ(springs.structural, 18);
  EXPECT_EQ(springs.nodes.size(), 36u);
  EXPECT_EQ(std::set(springs.nodes.begin(), springs.nodes.begin() + 18).size(), 18u);
}

TEST(Springs, StiffnessOfTwoTriangles) {
  // A unit square, its diagonal 0-3: areas 1/2, so A = 1/3 on the diagonal and 1/6 on the rim.
  TriMesh square;
  square.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  square.triangles = {{0, 1, 3}, {0, 3, 2}};
  SpringMaterial material{.stiffness = 600, .anisotropy = 4, .shear = 0.5, .bending = 12};
  const Springs plain = make_springs(square, {}, material);
  ASSERT_EQ(plain.structural, 5);
  ASSERT_EQ(plain.nodes.size(), 6u);
  EXPECT_EQ(plain.nodes[2], (std::array{0, 3}));
  EXPECT_DOUBLE_EQ(plain.stiffness[0], 100.0);  // Y A / L^2 = 600 / 6
  EXPECT_DOUBLE_EQ(plain.stiffness[2], 100.0);  // 600 / 3 / 2
  EXPECT_EQ(plain.nodes[5], (std::array{1, 2}));
  EXPECT_DOUBLE_EQ(plain.stiffness[5], 51.0);  // (0.5 * 600 + 12 / 2) / 3 / 2
  EXPECT_DOUBLE_EQ(plain.rest_length[5], std::sqrt(2.0));
  const Springs fibrous = make_springs(square, std::vector<Vec3>(4, Vec3::UnitX()), material);
  EXPECT_DOUBLE_EQ(fibrous.stiffness[0], 400.0);  // along: times the anisotropy
  EXPECT_DOUBLE_EQ(fibrous.stiffness[1], 100.0);  // 0-2, across
  EXPECT_DOUBLE_EQ(fibrous.stiffness[2], 175.0);  // at 45 degrees: 1 + 3 / 4
  EXPECT_DOUBLE_EQ(fibrous.fibre_share[2], 0.5);
}

TEST(Springs, RefusesNodesInOnePlace) {
  TriMesh mesh = unit_cube();
  mesh.vertices[1] = mesh.vertices[0];
  EXPECT_THROW(make_springs(mesh, {}, {}), Error);
}

TEST(Springs, OneSpringPullsByHookeAlongItself) {
  Springs springs;
  springs.nodes = {{0, 1}};
  springs.stiffness = {10.0};
  springs.rest_length = {1.0};
  Points f(2, Point{});
  add_spring_forces(springs, springs.rest_length, {Point{0, 0, 0, 0}, Point{0, 3, 0, 0}}, f);
  EXPECT_EQ(to_vec(f[0]), Vec3(0, 20, 0));
  EXPECT_EQ(to_vec(f[1]), Vec3(0, -20, 0));
  EXPECT_DOUBLE_EQ(spring_energy(springs, {1.0}, {Point{0, 0, 0, 0}, Point{0, 3, 0, 0}}), 20.0);
  add_spring_forces(springs, springs.rest_length, {Point{}, Point{}},
                    f);  // no length: no force, no NaN
  EXPECT_EQ(to_vec(f[0]), Vec3(0, 20, 0));
}

TEST(Springs, ForceIsMinusTheGradientOfTheEnergyAndSumsToNothing) {
  const TriMesh mesh = spindle(8, 5);
  const Springs springs =
      make_springs(mesh, std::vector<Vec3>(mesh.vertices.size(), Vec3::UnitY()), {});
  const Points x = moved(to_points(mesh.vertices), 1.0, noise(mesh.vertices.size(), 0.004, 4));
  std::vector<double> rest = springs.rest_length;
  for (double& l : rest) l *= 0.95;
  Points f(x.size(), Point{});
  add_spring_forces(springs, rest, x, f);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  const double h = 1e-6;
  for (size_t i = 0; i < x.size(); ++i) {
    force += to_vec(f[i]);
    torque += to_vec(x[i]).cross(to_vec(f[i]));
    for (int k = 0; k < 3; ++k) {
      Points plus(x), minus(x);
      plus[i][k] += h;
      minus[i][k] -= h;
      const double slope =
          (spring_energy(springs, rest, plus) - spring_energy(springs, rest, minus)) / (2 * h);
      EXPECT_NEAR(f[i][k], -slope, 1e-7);
    }
  }
  EXPECT_LT(force.norm(), 1e-13);  // N, beside 10
  EXPECT_LT(torque.norm(), 1e-14);
}

TEST(Springs, RestShapeIsCalm) {
  const TriMesh mesh = spindle();
  const Springs springs = make_springs(mesh, {}, {});
  Points f(mesh.vertices.size(), Point{});
  add_spring_forces(springs, springs.rest_length, to_points(mesh.vertices), f);
  for (const Point& row : f) EXPECT_LT(to_vec(row).norm(), 1e-13);
  EXPECT_LT(spring_energy(springs, springs.rest_length, to_points(mesh.vertices)), 1e-25);
}

// The strain of all edges against that of the edges one by one.
TEST(Springs, StrainOfTheEdges) {
  const TriMesh mesh = spindle(8, 5);
  const Points target = to_points(mesh.vertices);
  const Springs springs = make_springs(mesh, {}, {});
  const Points x = moved(target, 1.0, noise(target.size(), 2e-3, 5));
  std::vector<double> rest, length;
  for (const double at_rest : springs.rest_length) rest.push_back(0.98 * at_rest);
  spring_lengths(springs, x, length);
  double energy = 0.0, usual = 0.0, longest = 0.0;
  int reversed = 0;
  for (int k = 0; k < springs.structural; ++k) {
    const auto& [a, b] = springs.nodes[k];
    EXPECT_DOUBLE_EQ(length[k], norm(x[a] - x[b]));
    energy += 0.5 * springs.stiffness[k] * std::pow(length[k] - rest[k], 2);
    usual += 0.5 * springs.stiffness[k] * std::pow(springs.rest_length[k], 2);
    reversed += dot(x[a] - x[b], target[a] - target[b]) < 0.0;
    longest = std::max(longest, length[k] / springs.rest_length[k]);
  }
  const EdgeStrain strain = strain_of_edges(springs, rest, x, target, 1.001 * longest);
  EXPECT_NEAR(strain.energy, energy, 1e-13 * energy);
  EXPECT_NEAR(strain.reference_energy, usual, 1e-13 * usual);
  EXPECT_EQ(strain.reversed, reversed);
  EXPECT_TRUE(strain.within_limit);
  EXPECT_FALSE(strain_of_edges(springs, rest, x, target, 0.999 * longest).within_limit);
  Points broken = x;
  broken[x.size() / 2][1] = std::nan("");
  EXPECT_FALSE(strain_of_edges(springs, rest, broken, target, 1.001 * longest).within_limit);
}

TEST(Springs, MassesAddUpToDensityTimesVolume) {
  const std::vector<double> mass = lumped_masses(unit_cube(), 1060.0);
  EXPECT_NEAR(std::accumulate(mass.begin(), mass.end(), 0.0), 1060.0, 1e-12);
  for (double m : mass) EXPECT_GT(m, 0.0);
}

// A leapfrog step is stable below 2 / omega. The bound of omega^2 is an upper one, so a step by the
// bound must be stable, and one four times as long must not be.
TEST(Springs, FrequencyBoundTellsTheStableStep) {
  const TriMesh mesh = spindle(8, 5);
  const Springs springs = make_springs(mesh, {}, {});
  const std::vector<double> mass = lumped_masses(mesh, 1060.0);
  std::vector<char> driven(mass.size(), 0);
  const double omega2 = highest_frequency_squared(springs, mass, driven);
  const auto energy_after = [&](double h) {
    Points x = moved(to_points(mesh.vertices), 1.0, noise(mass.size(), 1e-7, 5)),
           v(x.size(), Point{});
    for (int step = 0; step < 400; ++step) {
      Points f(x.size(), Point{});
      add_spring_forces(springs, springs.rest_length, x, f);
      for (size_t i = 0; i < x.size(); ++i) {
        v[i] += h / mass[i] * f[i];
        x[i] += h * v[i];
      }
    }
    return spring_energy(springs, springs.rest_length, x);
  };
  const double start = energy_after(0.0);
  EXPECT_LT(energy_after(1.98 / std::sqrt(omega2)), 100.0 * start);
  EXPECT_FALSE(energy_after(8.0 / std::sqrt(omega2)) <
               1e6 * start);  // the negation also accepts NaN
  driven.assign(driven.size(), 1);
  EXPECT_EQ(highest_frequency_squared(springs, mass, driven), 0.0);
}

}  // namespace
}  // namespace thew::tests
