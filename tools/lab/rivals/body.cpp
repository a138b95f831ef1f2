// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/body.h"

#include "muscles/springs.h"
#include "muscles/volume.h"

namespace thew::tools {
namespace {

RivalBody body_at_rest(const std::vector<Vec3>& nodes) {
  RivalBody body;
  body.rest = nodes;
  body.x = to_points(nodes);
  body.v.assign(nodes.size(), Point{});
  body.driven.assign(nodes.size(), 0);
  return body;
}

}  // namespace

RivalBody surface_body(const TriMesh& mesh, double density) {
  RivalBody body = body_at_rest(mesh.vertices);
  body.triangles = mesh.triangles;
  body.mass = lumped_masses(mesh, density);
  body.surface.assign(mesh.vertices.size(), 1);
  return body;
}

RivalBody solid_body(const TetMesh& mesh, double density) {
  RivalBody body = body_at_rest(mesh.vertices);
  body.triangles = boundary(mesh);
  body.tetrahedra = mesh.tetrahedra;
  body.mass.assign(mesh.vertices.size(), 0.0);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    for (const int node : t) body.mass[node] += 0.25 * density * signed_volume(mesh, t);
  }
  body.surface.assign(mesh.vertices.size(), 0);
  for (const Triangle& t : body.triangles) {
    for (const int node : t) body.surface[node] = 1;
  }
  return body;
}

double volume_of(const RivalBody& body) { return enclosed_volume(body.x, body.triangles); }

void drive_nodes(const Surroundings& around, double time, double h, RivalBody& body) {
  if (!around.drive) return;
  const Points before = body.x;
  around.drive(time, body.rest, body.x);
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (body.driven[i]) body.v[i] = 1.0 / h * (body.x[i] - before[i]);
  }
}

void keep_out(const Surroundings& around, double time, RivalBody& body) {
  if (!around.beyond) return;
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (!body.surface[i] || body.driven[i]) continue;
    const Vec3 depth = around.beyond(time, to_vec(body.x[i]));
    if (depth.isZero(0.0)) continue;
    body.x[i] -= to_point(depth);
    const Point n = to_point(depth.normalized());
    body.v[i] -= std::max(dot(body.v[i], n), 0.0) * n;
  }
}

Momentum momentum_of(const RivalBody& body) {
  Momentum sum;
  for (size_t i = 0; i < body.x.size(); ++i) {
    const Vec3 p = body.mass[i] * to_vec(body.v[i]);
    sum.linear += p;
    sum.angular += to_vec(body.x[i]).cross(p);
  }
  return sum;
}

}  // namespace thew::tools
