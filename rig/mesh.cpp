// SPDX-License-Identifier: Apache-2.0
#include "rig/mesh.h"

#include <bit>
#include <cstdint>
#include <unordered_map>

namespace thew::rig {
namespace {

struct PositionHash {
  size_t operator()(const Vec3& p) const {
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      const uint64_t bits = std::bit_cast<uint64_t>(p[k] + 0.0);  // -0 and 0 are equal
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

}  // namespace

double enclosed_volume(const TriMesh& mesh) {
  return enclosed_volume(mesh.vertices, mesh.triangles);
}

double enclosed_volume(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles) {
  if (positions.empty()) return 0.0;
  Vec3 centroid = Vec3::Zero();
  for (const Vec3& p : positions) centroid += p;
  centroid /= static_cast<double>(positions.size());
  double volume = 0.0;  // V = sum of x1 . (x2 x x3) / 6
  for (const Triangle& t : triangles) {
    const Vec3 a = positions[t[0]] - centroid;
    const Vec3 b = positions[t[1]] - centroid;
    const Vec3 c = positions[t[2]] - centroid;
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

std::vector<Vec3> vertex_normals(const TriMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3 twice_area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    for (int corner : t) normals[corner] += twice_area;
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    if (length > 0.0) n /= length;  // zero stays zero: a vertex without area has no normal
  }
  return normals;
}

WeldResult weld(const TriMesh& mesh) {
  WeldResult result;
  std::unordered_map<Vec3, int, PositionHash> first_at;
  first_at.reserve(mesh.vertices.size());
  result.map_back.reserve(mesh.vertices.size());
  for (const Vec3& p : mesh.vertices) {
    const auto [entry, is_new] =
        first_at.try_emplace(p, static_cast<int>(result.mesh.vertices.size()));
    if (is_new) result.mesh.vertices.push_back(p);
    result.map_back.push_back(entry->second);
  }
  for (const Triangle& t : mesh.triangles) {
    const Triangle merged{result.map_back[t[0]], result.map_back[t[1]], result.map_back[t[2]]};
    if (merged[0] != merged[1] && merged[1] != merged[2] && merged[2] != merged[0]) {
      result.mesh.triangles.push_back(merged);
    }
  }
  return result;
}

std::vector<int> first_at_position(const TriMesh& mesh) {
  const WeldResult welded = weld(mesh);
  std::vector<int> first(welded.mesh.vertices.size(), -1), out;
  for (size_t i = 0; i < welded.map_back.size(); ++i) {
    int& one = first[welded.map_back[i]];
    if (one < 0) one = static_cast<int>(i);
    out.push_back(one);
  }
  return out;
}

std::vector<Triangle> joined_triangles(const TriMesh& mesh) {
  const std::vector<int> first = first_at_position(mesh);
  std::vector<Triangle> triangles = mesh.triangles;
  for (Triangle& t : triangles) {
    for (int& i : t) i = first[i];
  }
  return triangles;
}

}  // namespace thew::rig
