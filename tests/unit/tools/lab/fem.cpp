// SPDX-License-Identifier: Apache-2.0
//
// The yardstick against what is known in closed form, before anything is measured with it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tests {
namespace {

TriMesh ball_surface(int triangles) { return paper_ball(triangles); }

// A bar 3 x 1 x 1 of cubes of six tetrahedra each.
FemBody bar(const FemMaterial& material, int order) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  FemBody body;
  body.order = order;
  body.material = material;
  std::map<std::array<int, 3>, int> index;
  const auto node = [&](const std::array<int, 3>& p) {
    const auto [at, added] = index.try_emplace(p, static_cast<int>(body.rest.size()));
    if (added) body.rest.push_back(0.25 * Vec3(p[0], p[1], p[2]));
    return at->second;
  };
  for (int cube = 0; cube < 6 * 2 * 2; ++cube) {
    for (const auto& o : kOrders) {
      std::array<std::array<int, 3>, 4> c;
      c[0] = {2 * (cube / 4), 2 * (cube / 2 % 2), 2 * (cube % 2)};
      for (int k = 0; k < 3; ++k) {
        c[k + 1] = c[k];
        c[k + 1][o[k]] += 2;
      }
      const auto v = [&](int k) {
        return Vec3(c[k][0] - c[0][0], c[k][1] - c[0][1], c[k][2] - c[0][2]);
      };
      if (v(1).cross(v(2)).dot(v(3)) < 0.0) std::swap(c[2], c[3]);
      for (const auto& corner : c) body.elements.push_back(node(corner));
      for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}) {
        std::array<int, 3> middle;
        for (int k = 0; k < 3; ++k) middle[k] = (c[a][k] + c[b][k]) / 2;
        if (order == 2) body.elements.push_back(node(middle));
      }
    }
  }
  prepare(body);
  return body;
}

// Patch test: where the surface follows an affine map, so does the inside.
double patch_error(FemBody body) {
  Mat3 f;
  f << 1.1, 0.05, 0.0, 0.02, 0.95, 0.03, 0.0, 0.04, 1.02;
  if (!body.material.neo_hookean) f = Mat3::Identity() + 1e-3 * (f - Mat3::Identity());
  for (size_t i = 0; i < body.rest.size(); ++i) {
    if (!body.surface[i]) continue;
    body.x[i] = f * body.rest[i];
    for (int k = 0; k < 3; ++k) body.fixed[3 * i + k] = 1;
  }
  FemStep step;
  step.direct = true;
  step.tolerance = 1e-13;
  step.iterations = 30;
  solve_step(body, step);
  double worst = 0.0;
  for (size_t i = 0; i < body.rest.size(); ++i) {
    worst = std::max(worst, (body.x[i] - f * body.rest[i]).norm());
  }
  return worst;
}

TEST(Fem, PassesThePatchTest) {
  const FemMaterial linear{.shear = 1000.0, .lambda = 500.0, .penalty = 0.0};
  EXPECT_LT(patch_error(linear_ball(ball_surface(300), 1000, linear)), 1e-9);
  FemBody cube = bar({.neo_hookean = true, .shear = 1000.0, .penalty = 1e5}, 2);
  for (size_t i = 0; i < cube.rest.size(); ++i) {
    const Vec3& p = cube.rest[i];
    cube.surface[i] =
        p.x() == 0 || p.x() == 3 || p.y() == 0 || p.y() == 1 || p.z() == 0 || p.z() == 1;
  }
  EXPECT_LT(patch_error(cube), 1e-9);
}

TEST(Fem, ABarInTensionHasYoungsModulus) {
  for (int order : {1, 2}) {
    FemMaterial material{.shear = 1000.0, .lambda = 2000.0, .penalty = 0.0};
    FemBody body = bar(material, order);
    // Pulled evenly at x = 3; the planes x = 0, y = 0, z = 0 slide.
    body.load.assign(body.rest.size(), Vec3::Zero());
    const double pull = 1.0;  // Pa over 1 m^2
    for (size_t i = 0; i < body.rest.size(); ++i) {
      const Vec3& p = body.rest[i];
      for (int k = 0; k < 3; ++k) body.fixed[3 * i + k] = p[k] == 0.0;
    }
    // The face's load by an even pressure: hold the face at an even displacement instead and sum
    // the forces, which is the same for a state of even strain.
    const double young = 1000.0 * (3.0 * 2000.0 + 2.0 * 1000.0) / (2000.0 + 1000.0);
    const double strain = pull / young;
    for (size_t i = 0; i < body.rest.size(); ++i) {
      if (body.rest[i].x() != 3.0) continue;
      body.x[i].x() = 3.0 * (1.0 + strain);
      body.fixed[3 * i] = 1;
    }
    FemStep step;
    step.direct = true;
    step.tolerance = 1e-13;
    EXPECT_TRUE(solve_step(body, step).converged);
    const double poisson = 2000.0 / (2.0 * (2000.0 + 1000.0));
    for (size_t i = 0; i < body.rest.size(); ++i) {
      const Vec3 expected = body.rest[i].cwiseProduct(
          Vec3(1.0 + strain, 1.0 - poisson * strain, 1.0 - poisson * strain));
      EXPECT_LT((body.x[i] - expected).norm(), 1e-9);
    }
  }
}

// Radial displacement under an even pressure p: -p r / (3 K).
double shrinking_under_pressure(FemBody body, const std::vector<Triangle>& outside,
                                double pressure) {
  body.load.assign(body.rest.size(), Vec3::Zero());
  for (const Triangle& t : outside) {
    const Vec3 area =
        0.5 * (body.rest[t[1]] - body.rest[t[0]]).cross(body.rest[t[2]] - body.rest[t[0]]);
    for (int corner : t) body.load[corner] -= pressure / 3.0 * area;
  }
  FemStep step;
  step.direct = true;
  step.tolerance = 1e-12;
  EXPECT_TRUE(solve_step(body, step).converged);
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < body.rest.size(); ++i) {
    if (!body.surface[i]) continue;
    sum += (body.x[i] - body.rest[i]).dot(body.rest[i].normalized()) / body.rest[i].norm();
    ++count;
  }
  return -sum / count;
}

TEST(Fem, ASphereUnderPressureShrinksByItsBulkModulus) {
  const FemMaterial linear{.shear = 1000.0, .lambda = 1000.0, .penalty = 3000.0};
  const TriMesh surface = ball_surface(1470);
  FemBody body = linear_ball(surface, 2691, linear);
  // Held without stress: three places of one end, two of the other, one aside.
  const auto nearest = [&](const Vec3& p) {
    size_t best = 0;
    for (size_t i = 0; i < surface.vertices.size(); ++i) {
      if ((body.rest[i] - p).norm() < (body.rest[best] - p).norm()) best = i;
    }
    return 3 * best;
  };
  const size_t low = nearest({0, -1, 0}), high = nearest({0, 1, 0}), side = nearest({1, 0, 0});
  for (size_t d : {low, low + 1, low + 2, high, high + 2, side + 2}) body.fixed[d] = 1;
  const double bulk = 1000.0 + 2.0 / 3.0 * 1000.0 + 3000.0;
  const double measured = shrinking_under_pressure(
      body,
      boundary({body.rest,
                [&] {
                  std::vector<Tetrahedron> all;
                  for (size_t e = 0; e < body.elements.size(); e += 4) {
                    all.push_back({body.elements[e], body.elements[e + 1], body.elements[e + 2],
                                   body.elements[e + 3]});
                  }
                  return all;
                }()}),
      1.0);
  EXPECT_NEAR(measured, 1.0 / (3.0 * bulk), 0.02 / (3.0 * bulk));
}

TEST(Fem, TheFillingHasTheSurfaceAndNearlyTheCounts) {
  for (const auto& [triangles, tetrahedra] : {std::pair{1470, 2691}, {1766, 3528}}) {
    const TetMesh mesh = fill_ball(ball_surface(triangles), tetrahedra);
    EXPECT_NEAR(static_cast<double>(mesh.tetrahedra.size()), tetrahedra, 0.03 * tetrahedra);
    for (const Tetrahedron& t : mesh.tetrahedra) EXPECT_GT(signed_volume(mesh, t), 0.0);
  }
}

// Largest radius at the equator of a ball squeezed to 70 % of its height.
double bulge(int n) {
  FemBody body = octant_ball(1.0, n, {.neo_hookean = true, .shear = 1000.0, .penalty = 1e6});
  const double before = fem_volume(body);
  EXPECT_TRUE(close_planes(1.0, 0.7, 4, {}, body).converged);
  EXPECT_NEAR(fem_volume(body) / before, 1.0, 2e-3);
  double most = 0.0;
  for (const Vec3& p : body.x) most = std::max(most, p.x());
  return most;
}

TEST(Fem, TheNeoHookeanBallConverges) {
#ifdef THEW_SANITIZED
  GTEST_SKIP() << "a minute there of what the tests above run as well";
#endif
  const double coarse = bulge(2), middle = bulge(4), fine = bulge(6);
  EXPECT_LT(std::abs(fine - middle), 0.3 * std::abs(middle - coarse));
  EXPECT_LT(std::abs(fine - middle), 5e-3);
}

}  // namespace
}  // namespace thew::tests
