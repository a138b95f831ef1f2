// SPDX-License-Identifier: Apache-2.0
// The material must not change with the mesh, with the order of its parts, or with the units.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "muscles/springs.h"
#include "muscles/volume.h"
#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

double energy_of(const TriMesh& mesh, const std::vector<Vec3>& fibres,
                 const SpringMaterial& material, const auto& deform) {
  const Springs springs = make_springs(mesh, fibres, material);
  Points x;
  for (const Vec3& p : mesh.vertices) x.push_back(to_point(deform(p)));
  return spring_energy(springs, springs.rest_length, x);
}

TEST(Refinement, MassesSumToTheSame) {
  TriMesh mesh = spindle();
  double first = 0.0;
  for (int level = 0; level < 3; ++level, mesh = subdivided(mesh)) {
    const std::vector<double> mass = lumped_masses(mesh, 1060.0);
    const double sum = std::accumulate(mass.begin(), mass.end(), 0.0);
    if (level == 0) first = sum;
    EXPECT_NEAR(sum, first, 1e-12 * first);
  }
}

TEST(Refinement, StrainEnergyStaysWithinTwoPercent) {
  struct Strain {
    double x, y;
  };
  for (const Strain& by : {Strain{0.02, 0.0}, Strain{0.0, 0.02}, Strain{0.02, 0.02}}) {
    for (bool fibrous : {false, true}) {
      TriMesh mesh = spindle(24, 23);
      double energy[2];
      for (double& e : energy) {
        const std::vector<Vec3> fibres(fibrous ? mesh.vertices.size() : 0, Vec3::UnitY());
        e = energy_of(mesh, fibres, {.bending = 0.0}, [&](const Vec3& p) {
          return Vec3(p.x() * (1 + by.x), p.y() * (1 + by.y), p.z() * (1 + by.x));
        });
        mesh = subdivided(mesh);
      }
      EXPECT_NEAR(energy[1] / energy[0], 1.0, 0.02);
    }
  }
}

// Bent to a curvature c, opposite vertices L apart come nearer by ~ c^2 L^3, so that constant k
// loses its energy per area as h^4 and bending's k ~ 1/h^2 as h^2. It is no plate, and this is the
// measure of it.
TEST(Refinement, BendingEnergyOfASheetFallsAsTheSquareOfTheMesh) {
  const double radius = 0.05;  // m, of the cylinder on which the sheet is rolled
  const auto roll = [&](const Vec3& p) {
    const double a = p.x() / radius;
    return Vec3(radius * std::sin(a), p.y(), radius * (1 - std::cos(a)));
  };
  const auto energy = [&](int n, const SpringMaterial& material) {
    return energy_of(sheet(n, n, 0.08 / n), {}, material, roll);
  };
  const SpringMaterial bending{.stiffness = 0.0, .bending = 1e-4}, membrane{.bending = 0.0};
  for (int n : {20, 40}) {
    EXPECT_NEAR(energy(n, bending) / energy(2 * n, bending), 4.0, 0.4);
    EXPECT_NEAR(energy(n, membrane) / energy(2 * n, membrane), 16.0, 1.6);
  }
}

struct Shuffled {
  TriMesh mesh;
  std::vector<int> place;  // new index of each old node
};

Shuffled shuffled(const TriMesh& mesh, unsigned seed) {
  std::mt19937 engine(seed);
  const auto order = [&](size_t n) {
    std::vector<int> out(n);
    std::iota(out.begin(), out.end(), 0);
    for (size_t i = n - 1; i > 0; --i) std::swap(out[i], out[engine() % (i + 1)]);
    return out;
  };
  Shuffled out{mesh, order(mesh.vertices.size())};
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    out.mesh.vertices[out.place[i]] = mesh.vertices[i];
  }
  const std::vector<int> faces = order(mesh.triangles.size());
  for (size_t i = 0; i < faces.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const int turn = engine() % 3;
    for (int k = 0; k < 3; ++k) out.mesh.triangles[faces[i]][k] = out.place[t[(k + turn) % 3]];
  }
  return out;
}

TEST(Refinement, OrderOfNodesAndFacesMattersOnlyToRounding) {
  const TriMesh mesh = spindle();
  const Shuffled other = shuffled(mesh, 11);
  const Points change = noise(mesh.vertices.size(), 0.002, 12);
  Points x = moved(to_points(mesh.vertices), 1.0, change), y(x);
  for (size_t i = 0; i < x.size(); ++i) y[other.place[i]] = x[i];
  const Springs a = make_springs(mesh, {}, {}), b = make_springs(other.mesh, {}, {});
  ASSERT_EQ(a.structural, b.structural);
  Points f(x.size(), Point{}), g(f);
  add_spring_forces(a, a.rest_length, x, f);
  add_spring_forces(b, b.rest_length, y, g);
  Points volume_f, volume_g;
  volume_gradient(x, mesh.triangles, volume_f);
  volume_gradient(y, other.mesh.triangles, volume_g);
  const double force = std::sqrt(dot(f, f)), area = std::sqrt(dot(volume_f, volume_f));
  for (size_t i = 0; i < x.size(); ++i) {
    EXPECT_LT(to_vec(f[i] - g[other.place[i]]).norm(), 1e-12 * force);
    EXPECT_LT(to_vec(volume_f[i] - volume_g[other.place[i]]).norm(), 1e-12 * area);
  }
  const double volume = enclosed_volume(x, mesh.triangles);
  EXPECT_NEAR(enclosed_volume(y, other.mesh.triangles), volume, 1e-12 * volume);
}

// Lengths times L, forces times F: stiffness per width scales by F / L, bending by F L.
TEST(Refinement, UnitsDoNotMatter) {
  const double to_length = 1000.0, to_force = 1e9;
  const TriMesh metres = spindle();
  TriMesh millimetres = metres;
  for (Vec3& p : millimetres.vertices) p *= to_length;
  const SpringMaterial si;
  SpringMaterial other = si;
  other.stiffness *= to_force / to_length;
  other.bending *= to_force * to_length;
  const Springs a = make_springs(metres, {}, si), b = make_springs(millimetres, {}, other);
  const Points x = moved(to_points(metres.vertices), 1.0, noise(metres.vertices.size(), 0.002, 13));
  Points y(x), f(x.size(), Point{}), g(f);
  for (Point& row : y) row *= to_length;
  add_spring_forces(a, a.rest_length, x, f);
  add_spring_forces(b, b.rest_length, y, g);
  const double force = std::sqrt(dot(f, f));
  for (size_t i = 0; i < x.size(); ++i) {
    EXPECT_LT(to_vec(g[i] / to_force - f[i]).norm(), 1e-13 * force);
  }
}

}  // namespace
}  // namespace thew::tests
