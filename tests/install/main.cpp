// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>

#include "muscles/volume.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/mesh.h"
#include "sim/cache/cache.h"
#include "sim/scene/scene.h"
#include "skin/surface/surface.h"

// The library was built so; with another alignment Skeleton and its like would be laid out anew.
static_assert(alignof(thew::rig::Transform) == alignof(double));

namespace {

thew::rig::TriMesh unit_cube() {
  thew::rig::TriMesh cube;
  for (int i = 0; i < 8; ++i) cube.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return cube;
}

bool is_one(double value) { return std::abs(value - 1.0) < 1e-15; }

bool check(const char* what, bool holds) {
  if (!holds) std::printf("%s does not hold\n", what);
  return holds;
}

// Whether `read` of a file that is not there throws the package's Error with the code of bad input.
template <class Read>
bool refuses(Read read) {
  try {
    read("no such file");
  } catch (const thew::Error& error) {
    return error.code() == thew::ErrorCode::kInput;
  }
  return false;
}

}  // namespace

int main() {
  const thew::rig::TriMesh cube = unit_cube();
  thew::rig::Points rows;
  for (const thew::rig::Vec3& vertex : cube.vertices) rows.push_back(thew::rig::to_point(vertex));
  bool fine = check("rig: a cube's volume is 1", is_one(thew::rig::enclosed_volume(cube)));
  fine &= check("rig: a cube is sound", thew::rig::find_defects(cube).empty());
  fine &= check("muscles: a cube's volume is 1",
                is_one(thew::muscles::enclosed_volume(rows, cube.triangles)));
  // These pull assimp, urdfdom and HDF5 into the link.
  fine &= check("rig: a missing mesh is refused",
                refuses([](const char* file) { thew::rig::import_mesh(file); }));
  fine &= check("rig: a missing URDF is refused",
                refuses([](const char* file) { thew::rig::import_urdf(file, "."); }));
  fine &= check("sim: a missing bake is refused",
                refuses([](const char* file) { thew::sim::BakeReader reader(file); }));
  return fine ? 0 : 1;
}
