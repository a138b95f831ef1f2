// SPDX-License-Identifier: Apache-2.0
#include "tools/render/draw_geometry.h"

#include <algorithm>
#include <cassert>

#include "rig/math.h"
#include "tools/base/bake_mesh.h"

namespace thew::tools {
namespace {

bool is_skin(const BakeMesh& mesh) { return mesh.kind == BakeMesh::Kind::kSkin; }

std::uint32_t name_hash(const std::string& name) {  // FNV-1a: by name, whatever the order
  std::uint32_t hash = 2166136261u;
  for (const unsigned char c : name) hash = (hash ^ c) * 16777619u;
  return hash ^ hash >> 15;
}

// sRGB. Muscles range from wine to brick, so that neighbours can be told apart.
std::array<std::uint8_t, 3> tint(const BakeMesh& mesh) {
  if (is_skin(mesh)) return {220, 172, 150};
  if (mesh.kind == BakeMesh::Kind::kBone) return {228, 214, 184};
  if (mesh.kind == BakeMesh::Kind::kProp) return {112, 126, 142};
  const std::uint32_t hash = name_hash(mesh.name);
  const int light = hash & 31, warm = hash >> 8 & 15;
  return {static_cast<std::uint8_t>(138 + light), static_cast<std::uint8_t>(34 + light / 2 + warm),
          static_cast<std::uint8_t>(46 + light / 2 - warm)};
}

// (u, cos angle, sin angle, belly) of each vertex, or its rest position.
std::vector<std::array<double, 4>> shader_coordinates(const BakeMesh& mesh) {
  std::vector<std::array<double, 4>> out(mesh.rest.vertices.size(), {0.0, 1.0, 0.0, 1.0});
  double first = 1e30, last = -1e30;
  for (const auto& [u, angle, belly] : mesh.coordinates) {
    first = std::min(first, u);
    last = std::max(last, u);
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (mesh.kind != BakeMesh::Kind::kMuscle) {
      const Vec3& p = mesh.rest.vertices[i];
      out[i] = {p.x(), p.y(), p.z(), 0.0};
    } else if (!mesh.coordinates.empty()) {
      const auto& [u, angle, belly] = mesh.coordinates[i];
      // A pole has no angle: zero leaves that of its neighbours.
      const SinCos turn = u > first && u < last ? sin_cos(angle) : SinCos{0.0, 0.0};
      out[i] = {u, turn.cos, turn.sin, belly};
    }
  }
  return out;
}

// What of a node's weight the multiplier goes by: none in the tendons.
double shown_weight(const BakeMesh& mesh, std::size_t i) {
  return mesh.coordinates.empty() ? mesh.weights[i] : mesh.coordinates[i][2] * mesh.weights[i];
}

std::vector<DrawConstant> mesh_constants(const BakeMesh& mesh) {
  std::vector<DrawConstant> constants(mesh.rest.vertices.size());
  const std::array<std::uint8_t, 3> colour = tint(mesh);
  const std::vector<std::array<double, 4>> coordinates = shader_coordinates(mesh);
  for (std::size_t i = 0; i < constants.size(); ++i) {
    std::copy(coordinates[i].begin(), coordinates[i].end(), constants[i].coordinate);
    constants[i].weight = mesh.weights.empty() ? -1.0f : static_cast<float>(shown_weight(mesh, i));
    std::copy(colour.begin(), colour.end(), constants[i].tint);
  }
  return constants;
}

DrawConstant halfway(const DrawConstant& a, const DrawConstant& b) {
  DrawConstant c = a;
  for (int k = 0; k < 4; ++k) c.coordinate[k] = 0.5f * (a.coordinate[k] + b.coordinate[k]);
  c.weight = 0.5f * (a.weight + b.weight);
  return c;
}

// From the middle of an edge to that of the cubic with ends p_i, p_j whose tangents are the edge d
// without its part along n: ((d . n_j) n_j - (d . n_i) n_i) / 8.
Vec3 bulge_of(const std::vector<Vec3>& p, const std::vector<Vec3>& normals, int i, int j) {
  const Vec3 d = p[j] - p[i];
  return 0.125 * (d.dot(normals[j]) * normals[j] - d.dot(normals[i]) * normals[i]);
}

// m, by how much edges are flatter than the surface that they stand for, in the mean.
double flatness_of(const BakeMesh& mesh, const DrawMesh& draw) {
  const std::vector<Vec3> normals = vertex_normals({mesh.rest.vertices, draw.triangles});
  double sum = 0.0;
  for (const auto& [i, j] : draw.edges) {
    sum += bulge_of(mesh.rest.vertices, normals, i, j).norm();
  }
  return draw.edges.empty() ? 0.0 : sum / draw.edges.size();
}

std::array<int, 2> edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

std::vector<std::array<int, 2>> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<std::array<int, 2>> edges;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) edges.push_back(edge_of(t[k], t[(k + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

DrawMesh append_mesh(const BakeMesh& mesh, double flat, DrawGeometry& geometry) {
  DrawMesh draw;
  draw.triangles = shaded_triangles(mesh);
  draw.edges = edges_of(draw.triangles);
  // Each edge between two triangles, though perhaps not the right two: good enough for drawing.
  geometry.closed[static_cast<int>(mesh.kind)] &=
      2 * draw.edges.size() == 3 * mesh.rest.triangles.size() && enclosed_volume(mesh.rest) > 0.0;
  if (!(flatness_of(mesh, draw) > flat)) draw.edges.clear();
  draw.first_vertex = geometry.constants.size();
  const std::vector<DrawConstant> constants = mesh_constants(mesh);
  geometry.constants.insert(geometry.constants.end(), constants.begin(), constants.end());
  const auto first = static_cast<std::uint32_t>(draw.first_vertex);
  const auto halfway_vertex = [&](int a, int b) {
    const auto at = std::lower_bound(draw.edges.begin(), draw.edges.end(), edge_of(a, b));
    return first + static_cast<std::uint32_t>(constants.size() + (at - draw.edges.begin()));
  };
  for (const auto& [a, b] : draw.edges) {
    geometry.constants.push_back(halfway(constants[a], constants[b]));
  }
  for (const auto& [i, j, k] : draw.triangles) {
    const std::uint32_t a = first + i, b = first + j, c = first + k;
    if (draw.edges.empty()) {
      geometry.indices.insert(geometry.indices.end(), {a, b, c});
      continue;
    }
    const std::uint32_t ab = halfway_vertex(i, j), bc = halfway_vertex(j, k),
                        ca = halfway_vertex(k, i);
    geometry.indices.insert(geometry.indices.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
  }
  for (const double w : mesh.weights) {
    geometry.largest_weight = std::max(geometry.largest_weight, static_cast<float>(w));
  }
  draw.vertex_count = geometry.constants.size() - draw.first_vertex;
  return draw;
}

DrawVertex draw_vertex(const Vec3& p, const Vec3& n) {
  return {{float(p.x()), float(p.y()), float(p.z())}, {float(n.x()), float(n.y()), float(n.z())}};
}

Vec3 vec(const float (&v)[3]) { return Vec3(v[0], v[1], v[2]); }

}  // namespace

Vec3 position_of(const DrawVertex& vertex) { return vec(vertex.position); }

DrawGeometry make_draw_geometry(const std::vector<BakeMesh>& meshes, double flat) {
  DrawGeometry geometry;
  geometry.meshes.resize(meshes.size());
  for (int kind = 0; kind < 4; ++kind) {
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      if (int(meshes[m].kind) != kind) continue;
      geometry.meshes[m] = append_mesh(meshes[m], flat, geometry);
    }
    geometry.first_index[kind + 1] = geometry.indices.size();
  }
  geometry.vertices.resize(geometry.constants.size());
  return geometry;
}

std::vector<std::vector<Vec3>> as_in_cache(std::vector<std::vector<Vec3>> positions) {
  for (std::vector<Vec3>& mesh : positions) {
    for (Vec3& p : mesh) {  // in a loop: g++ 12 drops the rounding of two doubles side by side
      for (double& value : p) value = static_cast<float>(value);
    }
  }
  return positions;
}

bool moves(const std::vector<Vec3>& to, SentMesh& sent) {
  const auto same = [](const Vec3& a, const Vec3& b) { return a.cast<float>() == b.cast<float>(); };
  if (sent.ever &&
      std::equal(to.begin(), to.end(), sent.positions.begin(), sent.positions.end(), same)) {
    return false;
  }
  sent = {true, as_in_cache({to}).front(), {}};
  for (const Vec3& p : sent.positions) sent.bounds.add(p);
  return true;
}

void place_vertices(const DrawMesh& mesh, const std::vector<Vec3>& positions,
                    DrawGeometry& geometry) {
  assert(positions.size() + mesh.edges.size() == mesh.vertex_count);
  const std::vector<Vec3>& p = positions;
  const std::vector<Vec3> normals = vertex_normals({p, mesh.triangles});
  DrawVertex* out = geometry.vertices.data() + mesh.first_vertex;
  for (std::size_t i = 0; i < p.size(); ++i) *out++ = draw_vertex(p[i], normals[i]);
  for (const auto& [i, j] : mesh.edges) {
    *out++ = draw_vertex(0.5 * (p[i] + p[j]) + bulge_of(p, normals, i, j),
                         (normals[i] + normals[j]).normalized());
  }
}

std::vector<DrawVertex> weight_quads(const std::vector<BakeMesh>& meshes,
                                     const DrawGeometry& geometry, const Vec3& eye, double unit,
                                     double width) {
  std::vector<DrawVertex> quads;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    for (std::size_t i = 0; i < meshes[m].weights.size(); ++i) {
      const DrawVertex& vertex = geometry.vertices[geometry.meshes[m].first_vertex + i];
      const Vec3 foot = position_of(vertex), normal = vec(vertex.normal);
      const Vec3 tip = foot + unit * shown_weight(meshes[m], i) * normal;
      const Vec3 line = eye - foot;
      const Vec3 side = 0.5 * width * line.norm() * normal.cross(line).normalized();
      const DrawVertex corners[4] = {
          draw_vertex(foot - side, normal), draw_vertex(foot + side, normal),
          draw_vertex(tip - side, normal), draw_vertex(tip + side, normal)};
      for (const int c : {0, 1, 2, 2, 1, 3}) quads.push_back(corners[c]);
    }
  }
  return quads;
}

}  // namespace thew::tools
