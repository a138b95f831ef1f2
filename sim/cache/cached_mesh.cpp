// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/cached_mesh.h"

#include <algorithm>

#include "rig/import/mesh_import.h"
#include "rig/text.h"
#include "sim/cache/cache.h"
#include "sim/cache/point_cache.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

// An animation is held as a whole.
void check_size(const fs::path& file, std::size_t samples, std::size_t vertices) {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // bytes
  const std::size_t bytes = samples * vertices * sizeof(Vec3);
  if (bytes <= kMost) return;
  refuse_file(file, std::to_string(samples) + " frames of " + std::to_string(vertices) +
                        " vertices take " + std::to_string(bytes >> 20) + " MiB, more than " +
                        std::to_string(kMost >> 20) + "; export fewer frames or a coarser mesh");
}

// Keeps one vertex of each place, as contact and a skin layer need it, and checks the surface.
void weld_all(const fs::path& file, const std::vector<int>& map_back, std::size_t nodes,
              MeshSamples& samples) {
  std::vector<std::size_t> first(nodes, map_back.size());
  for (std::size_t i = map_back.size(); i-- > 0;) first[static_cast<std::size_t>(map_back[i])] = i;
  for (std::vector<Vec3>& positions : samples.positions) {
    std::vector<Vec3> kept(nodes);
    for (std::size_t n = 0; n < nodes; ++n) kept[n] = positions[first[n]];
    check_positions(file, kept);
    positions = std::move(kept);
  }
}

void multiply(std::vector<Vec3>& positions, double scale) {
  if (scale == 1.0) return;
  for (Vec3& p : positions) p *= scale;
}

CachedMesh read_part(const BakeReader& bake, const fs::path& file, std::size_t mesh, double scale) {
  const BakeInfo& info = bake.info();
  const BakeMesh& of = info.meshes[mesh];
  CachedMesh out{of.name, {}, {}};
  check_size(file, info.frames.size(), of.rest.vertices.size());
  TriMesh rest = of.rest;
  multiply(rest.vertices, scale);
  WeldResult welded = weld(rest);
  for (std::size_t k = 0; k < info.frames.size(); ++k) {
    out.samples.times.push_back((info.frames[k] - info.frames[0]) / info.fps);
    out.samples.positions.push_back(bake.read_mesh(static_cast<int>(k), static_cast<int>(mesh)));
    multiply(out.samples.positions.back(), scale);
  }
  weld_all(file, welded.map_back, welded.mesh.vertices.size(), out.samples);
  out.rest = std::move(welded.mesh);
  check_closed(file.string() + ": " + of.name, out.rest,
               of.kind == BakeMesh::Kind::kBone ? Pieces::kAny : Pieces::kOne);
  return out;
}

}  // namespace

bool names_bake(const fs::path& file) { return file.extension() == ".h5"; }

CachedMesh read_cached_mesh(const fs::path& mesh, const fs::path& cache, double fps, double scale,
                            Pieces pieces) {
  if (!names_point_cache(cache)) {
    refuse_file(cache,
                "animated meshes are read from .h5 of Thew, .pc2 and .mdd; export it as one");
  }
  ImportedMesh imported =
      import_closed_mesh_whole(mesh, Eigen::Affine3d(Eigen::Scaling(scale)), pieces);
  const std::size_t points = imported.map_back.size();
  CachedMesh out{"", {}, read_point_cache(cache, points, fps)};
  check_size(cache, out.samples.times.size(), points);
  for (std::vector<Vec3>& positions : out.samples.positions) multiply(positions, scale);
  weld_all(cache, imported.map_back, imported.mesh.vertices.size(), out.samples);
  out.rest = std::move(imported.mesh);
  return out;
}

CachedMesh read_baked_mesh(const fs::path& file, const CachedPart& part, double scale) {
  const BakeReader bake(file);
  std::vector<std::string> names;
  std::vector<std::size_t> places;
  for (std::size_t m = 0; m < bake.info().meshes.size(); ++m) {
    const BakeMesh& mesh = bake.info().meshes[m];
    if (part.kind && mesh.kind != *part.kind) continue;
    names.push_back(mesh.name);
    if (part.name.empty() || mesh.name == part.name) places.push_back(m);
  }
  if (places.size() == 1) return read_part(bake, file, places[0], scale);
  const std::string has = names.empty() ? "none such" : names_text(names);
  if (part.name.empty()) refuse_file(file, "say by `part` which mesh is meant; it has " + has);
  refuse_file(file, "has no mesh \"" + part.name + "\"" + did_you_mean(part.name, names) +
                        "; it has " + has);
}

std::vector<CachedMesh> read_baked_bones(const fs::path& file, double scale) {
  const BakeReader bake(file);
  std::vector<CachedMesh> bones;
  for (std::size_t m = 0; m < bake.info().meshes.size(); ++m) {
    if (bake.info().meshes[m].kind != BakeMesh::Kind::kBone) continue;
    bones.push_back(read_part(bake, file, m, scale));
  }
  if (bones.empty()) refuse_file(file, "has no bones; give a bake with a rig");
  return bones;
}

}  // namespace thew::sim
