// SPDX-License-Identifier: Apache-2.0
// Files of others, read in a child process and in this one: alike, results and errors.
#include "rig/import/character_import.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "sim/cache/cache.h"
#include "tests/unit/rig/temp.h"
#include "thew/import.h"

namespace thew::tests {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(THEW_SOURCE_DIR) / "tests/scenes";

class ApiImport : public TempFolder {
 protected:
  ~ApiImport() override { set_import_mode(ImportMode::kIsolated); }
};

// What `read` gives, isolated first, then in this process.
template <typename Read>
auto both(const Read& read) {
  set_import_mode(ImportMode::kIsolated);
  auto isolated = read();
  set_import_mode(ImportMode::kInProcess);
  auto here = read();
  return std::pair(std::move(isolated), std::move(here));
}

TEST_F(ApiImport, AMeshIsReadAlike) {
  const auto [a, b] = both([] { return import_mesh(kScenes / "pair/skin.obj"); });
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.map_back, b.map_back);
  EXPECT_FALSE(a.mesh.vertices.empty());
}

TEST_F(ApiImport, ARigIsReadAlike) {
  const auto [a, b] = both([] { return import_urdf(kScenes / "pair/rig.urdf", kScenes / "pair"); });
  EXPECT_EQ(a.body_names, b.body_names);
  EXPECT_EQ(a.joint_names, b.joint_names);
  EXPECT_EQ(a.parent, b.parent);
  EXPECT_EQ(a.lower, b.lower);
  ASSERT_EQ(a.joint_in_parent.size(), b.joint_in_parent.size());
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.joint_in_parent[i].matrix(), b.joint_in_parent[i].matrix());
    EXPECT_EQ(a.joint_axes[i], b.joint_axes[i]);
  }
}

TEST_F(ApiImport, ACharacterIsReadAlike) {
  const auto [a, b] = both([] { return import_character(kScenes / "figure/figure.gltf"); });
  EXPECT_EQ(a.skeleton.body_names, b.skeleton.body_names);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.skin.weight, b.skin.weight);
  ASSERT_EQ(a.bind.size(), b.bind.size());
  for (size_t i = 0; i < a.bind.size(); ++i) EXPECT_EQ(a.bind[i].matrix(), b.bind[i].matrix());
}

TEST_F(ApiImport, SeveralCachesAreOpenAtOnceInOneProcess) {
  set_import_mode(ImportMode::kInProcess);
  const std::filesystem::path golden = std::filesystem::path(THEW_SOURCE_DIR) / "tests/golden";
  const BakeReader muscle(golden / "one_muscle/bake.h5");
  const BakeReader arm(golden / "arm/bake.h5");
  const BakeFrame here = muscle.read(1), of_arm = arm.read(0);
  EXPECT_EQ(muscle.read_mesh(1, 0), here.positions[0]);
  set_import_mode(ImportMode::kIsolated);
  EXPECT_EQ(BakeReader(golden / "one_muscle/bake.h5").read(1).positions, here.positions);
  EXPECT_EQ(BakeReader(golden / "arm/bake.h5").read(0).positions, of_arm.positions);
}

TEST_F(ApiImport, WhatCannotBeReadIsRefusedAlike) {
  const auto refusals = [](const auto& read) {
    const auto [isolated, here] = both([&] { return input_error(read); });
    EXPECT_NE(isolated, "");
    EXPECT_EQ(isolated, here);
  };
  const auto missing = folder / "missing";
  refusals([&] { import_mesh(missing / "a.obj"); });
  refusals([&] { import_urdf(missing / "a.urdf", missing); });
  refusals([&] { import_character(missing / "a.gltf"); });
  refusals([&] { BakeReader reader(missing / "bake.h5"); });
  const auto obj = write("broken.obj", "v 0 0\nf 1 2 9\n");
  refusals([&] { import_mesh(obj); });
  const auto urdf = write("broken.urdf", "<robot name=\"a\"><link/></robot>");
  refusals([&] { import_urdf(urdf, folder); });
  const auto gltf = write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": 7}");
  refusals([&] { import_character(gltf); });
  const auto collada = write("broken.dae", "<COLLADA><library_geometries>");
  refusals([&] { import_mesh(collada); });
  const auto cache = write("bake.h5", "no HDF5");
  refusals([&] { BakeReader reader(cache); });
}

// Also without a process of its own, a file names no other that lies elsewhere.
TEST_F(ApiImport, AFileOutsideItsFolderIsNotOpened) {
  write("secret.bin", std::string(64, '\0'));
  const auto file = write("inside/a.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
      "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                     "min": [0, 0, 0], "max": [1, 1, 1]}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "buffers": [{"uri": "../secret.bin", "byteLength": 36}]})");
  const auto [isolated, here] = both([&] { return input_error([&] { import_mesh(file); }); });
  EXPECT_HAS(here, "../secret.bin");
  EXPECT_EQ(isolated, here);
}

}  // namespace
}  // namespace thew::tests
