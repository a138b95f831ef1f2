// SPDX-License-Identifier: Apache-2.0
//
// Characters that are damaged: a clear error or a sound load, no crash and no hang.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>

#include "rig/import/character_import.h"
#include "rig/import/gltf_source.h"
#include "rig/import/mesh_import.h"
#include "rig/text.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

struct Tally {
  int loaded = 0, refused = 0;
};

void try_one(const fs::path& file, Tally& tally) {
  try {
    const Character character = import_character(file);
    ++tally.loaded;
    ASSERT_GT(character.skeleton.size(), 0) << file;
    std::vector<Affine> world;
    for (const BodyClip& clip : character.animations) {
      animated_bodies(character, clip, 0.5 * clip.duration, world);
    }
    Points x;
    skin_vertices(character.skin, character.mesh, character.bind, x);
    if (!names_gltf(file)) return;
    const GltfSource source = read_gltf_source(file);
    EXPECT_FALSE(source.json.empty()) << file;
    for (const auto& vectors : source.vectors) EXPECT_GE(vectors.accessor, 0) << file;
  } catch (const Error& error) {
    ++tally.refused;
    const std::string what = error.what();
    EXPECT_NE(what.find(file.filename().string()), std::string::npos) << what;
    EXPECT_GT(what.size(), file.string().size() + 20) << what;
  }
}

const fs::path kModels = "/usr/share/assimp/models";

// Those with one of the endings, and all of the folder of malformed ones.
std::vector<fs::path> model_files(const std::vector<std::string>& endings) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(kModels)) {
    std::string ending = entry.path().extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(c));
    const bool wanted = std::find(endings.begin(), endings.end(), ending) != endings.end() ||
                        entry.path().parent_path().filename() == "invalid";
    if (entry.is_regular_file() && wanted) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(Characters, OfAssimpsTestModels) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "install assimp-testmodels to run this";
  const std::vector<fs::path> files = model_files({".bvh", ".gltf", ".glb", ".fbx", ".dae"});
  Tally tally;
  for (const fs::path& file : files) try_one(file, tally);
  std::printf("%d loaded, %d refused of %zu\n", tally.loaded, tally.refused, files.size());
  EXPECT_GT(tally.loaded, 10);
  EXPECT_GT(tally.refused, 2);
}

TEST(Meshes, OfAssimpsTestModels) {
  if (!fs::exists(kModels)) GTEST_SKIP() << "install assimp-testmodels to run this";
  const std::vector<fs::path> files =
      model_files({".obj", ".stl", ".ply", ".gltf", ".glb", ".fbx", ".dae"});
  Tally tally;
  for (const fs::path& file : files) {
    try {
      const ImportedMesh imported = import_mesh(file);
      ++tally.loaded;
      EXPECT_FALSE(imported.mesh.triangles.empty()) << file;
      find_defects(imported.mesh);
    } catch (const Error& error) {
      ++tally.refused;
      const std::string what = error.what();
      EXPECT_NE(what.find(file.filename().string()), std::string::npos) << what;
      EXPECT_GT(what.size(), file.string().size() + 20) << what;
    }
  }
  std::printf("%d loaded, %d refused of %zu\n", tally.loaded, tally.refused, files.size());
  EXPECT_GT(tally.loaded, 50);
  EXPECT_GT(tally.refused, 10);
}

class Mutants : public TempFolder {};

TEST_F(Mutants, OfRealCharacters) {
  std::vector<fs::path> sources = {fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf"};
  for (const char* name : {"cesium_man.gltf", "robot.glb"}) {
    sources.push_back(fs::path(THEW_SHARED_DATA) / name);
  }
  sources.emplace_back("/usr/share/assimp/models/BVH/Boxing_Toes.bvh");
  sources.emplace_back("/usr/share/assimp/models/FBX/huesitos.fbx");
  sources.emplace_back("/usr/share/assimp/models/Collada/kwxport_test_vcolors.dae");
  std::uint64_t random = 88172645463325252u;  // xorshift
  const auto next = [&](std::uint64_t below) {
    random ^= random << 13, random ^= random >> 7, random ^= random << 17;
    return random % below;
  };
  Tally tally;
  for (const fs::path& source : sources) {
    if (!fs::exists(source)) continue;
    const std::string bytes = read_whole(source, size_t{256} << 20);
    for (int k = 0; k < 40; ++k) {
      std::string hurt = bytes;
      if (k % 4 == 0) hurt.resize(next(hurt.size()));
      for (std::uint64_t n = next(20); n > 0 && k % 4 != 0 && !hurt.empty(); --n) {
        const std::uint64_t at =
            k % 4 == 1 ? next(std::min<size_t>(hurt.size(), 4000)) : next(hurt.size());
        const bool digit = std::isdigit(static_cast<unsigned char>(hurt[at])) != 0;
        if (k % 4 < 3) hurt[at] = static_cast<char>(next(256));
        if (k % 4 == 3 && digit) hurt[at] = static_cast<char>('0' + next(10));  // stays readable
      }
      try_one(write("m" + std::to_string(k) + source.extension().string(), hurt), tally);
    }
  }
  std::printf("%d loaded, %d refused\n", tally.loaded, tally.refused);
  EXPECT_GT(tally.refused, 10);
}

}  // namespace
}  // namespace thew::tests
