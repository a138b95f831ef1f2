// SPDX-License-Identifier: Apache-2.0
#include "thew/mesh.h"

#include <numeric>

#include "rig/api/arrays.h"
#include "rig/import/mesh_import.h"

namespace thew {
namespace rig {

TriMesh to_tri_mesh(std::span<const double> positions, std::span<const int> triangles) {
  const auto check = [](std::size_t size, const char* what) {
    if (size % 3 == 0) return;
    throw Error(ErrorCode::kUsage, std::string(what) + " has " + std::to_string(size) +
                                       " numbers; give three for each");
  };
  check(positions.size(), "positions");
  check(triangles.size(), "triangles");
  TriMesh mesh;
  mesh.vertices.reserve(positions.size() / 3);
  mesh.triangles.reserve(triangles.size() / 3);
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    mesh.vertices.emplace_back(positions[i], positions[i + 1], positions[i + 2]);
  }
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    mesh.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
  }
  return mesh;
}

void check_triangles(const TriMesh& mesh) {
  const int vertices = static_cast<int>(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      if (vertex >= 0 && vertex < vertices) continue;
      throw Error(ErrorCode::kUsage, "a triangle names vertex " + std::to_string(vertex) + " of " +
                                         std::to_string(vertices) + "; vertices count from 0");
    }
  }
}

std::vector<double> to_array(const std::vector<Vec3>& points) {
  std::vector<double> array;
  array.reserve(3 * points.size());
  for (const Vec3& p : points) array.insert(array.end(), {p.x(), p.y(), p.z()});
  return array;
}

std::vector<int> to_array(const std::vector<Triangle>& triangles) {
  std::vector<int> array;
  array.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) array.insert(array.end(), t.begin(), t.end());
  return array;
}

Mesh to_mesh(const TriMesh& mesh) { return {to_array(mesh.vertices), to_array(mesh.triangles)}; }

}  // namespace rig

double enclosed_volume(std::span<const double> positions, std::span<const int> triangles) {
  const rig::TriMesh mesh = rig::to_tri_mesh(positions, triangles);
  rig::check_triangles(mesh);
  return rig::enclosed_volume(mesh);
}

std::vector<MeshDefect> find_defects(const Mesh& mesh) {
  std::vector<MeshDefect> defects;
  for (const rig::Defect& defect :
       rig::find_defects(rig::to_tri_mesh(mesh.positions, mesh.triangles))) {
    defects.push_back({rig::defect_name(defect.kind), defect.count, defect.where, defect.fix});
  }
  return defects;
}

MeshFile read_mesh(const std::filesystem::path& file) {
  rig::ImportedMesh imported = rig::import_mesh(file);
  MeshFile out;
  out.welded = rig::to_mesh(imported.mesh);
  if (imported.order.node.empty()) {
    out.in_file_order = out.welded;
    out.welded_vertex.resize(imported.mesh.vertices.size());
    std::iota(out.welded_vertex.begin(), out.welded_vertex.end(), 0);
    return out;
  }
  out.welded_vertex = imported.order.node;
  out.in_file_order = {
      rig::to_array(rig::in_file_order(imported.order, std::move(imported.mesh.vertices))),
      rig::to_array(imported.order.triangles)};
  return out;
}

}  // namespace thew
