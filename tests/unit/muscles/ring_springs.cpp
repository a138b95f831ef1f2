// SPDX-License-Identifier: Apache-2.0
//
// Springs by node against springs by pair, and the gradient of the volume that they give.
#include "muscles/ring_springs.h"

#include <gtest/gtest.h>

#include "muscles/volume.h"
#include "tests/unit/muscles/shapes.h"

namespace thew::tests {
namespace {

struct Bodies {
  TriMesh mesh;
  Springs springs;
  RingSprings rings;
  Points x, v;
};

std::vector<char> every_third(size_t nodes) {
  std::vector<char> driven(nodes, 0);
  for (size_t i = 0; i < nodes; i += 3) driven[i] = 1;
  return driven;
}

// Octahedron and cube have nodes of low and mixed degree, and pairs of opposite vertices that
// belong to two edges.
Bodies moved(const TriMesh& mesh) {
  Bodies out;
  out.mesh = mesh;
  out.springs = make_springs(mesh, {}, {});
  out.rings =
      make_ring_springs(mesh.triangles, std::vector<char>(mesh.vertices.size(), 0), out.springs);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 d(0.01 * (i % 3), 0.02 * (i % 5), -0.015 * (i % 4));
    out.x.push_back(to_point(mesh.vertices[i] + d));
    out.v.push_back(to_point(Vec3(0.3 * (i % 7), -0.2 * (i % 2), 0.1 * (i % 5))));
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
    Points pairs(body.x.size(), Point{}), rings(body.x.size()), gradient(body.x.size()), expected;
    add_spring_forces(body.springs, body.springs.rest_length, body.x, pairs);
    const size_t middle = body.rings.slices.size() / 2, end = body.rings.slices.size();
    ring_forces(body.rings, body.rings.rest_length, {middle, end}, body.x, body.v, 0.0, rings,
                &gradient);
    ring_forces(body.rings, body.rings.rest_length, {0, middle}, body.x, body.v, 0.0, rings,
                &gradient);
    volume_gradient(body.x, mesh.triangles, expected);
    for (size_t i = 0; i < pairs.size(); ++i) {
      EXPECT_LT((to_vec(pairs[i]) - to_vec(rings[i])).norm(),
                1e-9 * (1.0 + to_vec(pairs[i]).norm()));
      EXPECT_LT((to_vec(gradient[i]) - to_vec(expected[i])).norm(), 1e-14);
    }
  }
}

// The forces at free nodes, where others are driven.
TEST(RingSprings, HaveThePairsProjectionsAndEdges) {
  for (const TriMesh& mesh : {octahedron(), tetrahedron(), spindle(), subdivided(unit_cube())}) {
    const Bodies body = moved(mesh);
    const std::vector<char> driven = every_third(body.x.size());
    const RingSprings rings = make_ring_springs(mesh.triangles, driven, body.springs);
    std::vector<double> rest;
    RingSprings::BySlot by_slot;
    for (const double length : body.springs.rest_length) rest.push_back(0.9 * length);
    lengths_by_slot(rings, rest, by_slot);
    Points projected(body.x.size(), Point{1, 2, 3, 0}), edges = projected, expected = projected,
                                                        all = projected;
    add_ring_projections(rings, by_slot, body.x, projected);
    add_ring_edges(rings, 2.5, body.x, edges);
    for (size_t k = 0; k < body.springs.nodes.size(); ++k) {
      const auto& [a, b] = body.springs.nodes[k];
      const Point pull = body.springs.stiffness[k] * (body.x[a] - body.x[b]);
      const Point unit = rest[k] / norm(body.x[a] - body.x[b]) * pull;
      expected[a] += unit;
      expected[b] -= unit;
      all[a] += 2.5 * pull;
      all[b] -= 2.5 * pull;
    }
    for (size_t i = 0; i < body.x.size(); ++i) {
      if (driven[i]) continue;
      EXPECT_LT(norm(projected[i] - expected[i]), 1e-12 * (1.0 + norm(expected[i])));
      EXPECT_LT(norm(edges[i] - all[i]), 1e-12 * (1.0 + norm(all[i])));
    }
  }
}

TEST(RingSprings, DashpotsGiveNoMomentum) {
  const Bodies body = moved(octahedron());
  Points still(body.x.size()), damped(body.x.size());
  ring_forces(body.rings, body.rings.rest_length, body.rings.all(), body.x, body.v, 0.0, still,
              nullptr);
  ring_forces(body.rings, body.rings.rest_length, body.rings.all(), body.x, body.v, 1e-2, damped,
              nullptr);
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
}  // namespace thew::tests
