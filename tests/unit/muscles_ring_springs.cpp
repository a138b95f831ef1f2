// SPDX-License-Identifier: Apache-2.0
//
// Springs by node against springs by pair, and the volume's gradient that falls out of them.
#include <gtest/gtest.h>

#include "muscles/ring_springs.h"
#include "muscles/volume.h"
#include "tests/unit/muscles_shapes.h"

namespace thew {
namespace {

struct Bodies {
  TriMesh mesh;
  Springs springs;
  RingSprings rings;
  Rows x, v;
};

// Octahedron and cube have low and mixed degrees, and pairs that two edges share.
Bodies moved(const TriMesh& mesh) {
  Bodies out;
  out.mesh = mesh;
  out.springs = make_springs(mesh, {}, {});
  out.rings =
      make_ring_springs(mesh.triangles, static_cast<int>(mesh.vertices.size()), out.springs);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 d(0.01 * (i % 3), 0.02 * (i % 5), -0.015 * (i % 4));
    out.x.push_back(to_row(mesh.vertices[i] + d));
    out.v.push_back(to_row(Vec3(0.3 * (i % 7), -0.2 * (i % 2), 0.1 * (i % 5))));
  }
  return out;
}

TriMesh octahedron() {
  TriMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return mesh;
}

TriMesh tetrahedron() {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(RingSprings, HaveTheForcesOfThePairs) {
  for (const TriMesh& mesh : {octahedron(), tetrahedron(), spindle(), subdivided(unit_cube())}) {
    const Bodies body = moved(mesh);
    Rows pairs(body.x.size(), Row{}), rings(body.x.size()), gradient(body.x.size()), expected;
    add_spring_forces(body.springs, body.springs.rest_length, body.x, pairs);
    const size_t middle = body.rings.slices.size() / 2, end = body.rings.slices.size();
    ring_forces(body.rings, middle, end, body.x, body.v, 0.0, rings, &gradient);
    ring_forces(body.rings, 0, middle, body.x, body.v, 0.0, rings, &gradient);
    volume_gradient(body.x, mesh.triangles, expected);
    for (size_t i = 0; i < pairs.size(); ++i) {
      EXPECT_LT((to_vec(pairs[i]) - to_vec(rings[i])).norm(),
                1e-9 * (1.0 + to_vec(pairs[i]).norm()));
      EXPECT_LT((to_vec(gradient[i]) - to_vec(expected[i])).norm(), 1e-14);
    }
  }
}

TEST(RingSprings, DashpotsGiveNoMomentum) {
  const Bodies body = moved(octahedron());
  Rows still(body.x.size()), damped(body.x.size());
  const size_t end = body.rings.slices.size();
  ring_forces(body.rings, 0, end, body.x, body.v, 0.0, still, nullptr);
  ring_forces(body.rings, 0, end, body.x, body.v, 1e-2, damped, nullptr);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  double power = 0.0, size = 0.0;
  for (size_t i = 0; i < still.size(); ++i) {
    const Vec3 f = to_vec(damped[i]) - to_vec(still[i]);
    sum += f;
    moment += to_vec(body.x[i]).cross(f);
    power += f.dot(to_vec(body.v[i]));
    size += f.norm();
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(sum.norm(), 1e-12 * size);
  EXPECT_LT(moment.norm(), 1e-12 * size);
  EXPECT_LT(power, 0.0);
}

}  // namespace
}  // namespace thew
