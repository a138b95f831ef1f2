// SPDX-License-Identifier: Apache-2.0
//
// The arm's own bones and skin, written to a cache and read back, against the arm itself. A touch
// of 1e-11 degree to its clip moves single nodes of the arm by a hundredth of a millimetre from
// frame 39 on, where two bones press on one muscle; up to there the two bakes are one.
#include <gtest/gtest.h>

#include <fstream>

#include "muscles/volume.h"
#include "rig/import/mesh_import.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "skin/depth.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

constexpr int kLast = 12;

class CachedArm : public TempFolder {
 protected:
  CachedArm() {
    fs::copy(THEW_SOURCE_DIR "/assets/arm", folder / "arm", fs::copy_options::recursive);
    std::vector<int> frames;
    for (int f = 1; f <= kLast; ++f) frames.push_back(f);
    bake_to("whole", build_model(read_scene(folder / "arm/arm.toml")), frames);
    fs::copy_file(folder / "whole/bake.h5", folder / "arm/bones.h5");
    std::ifstream in(folder / "arm/arm.toml");
    std::string text{std::istreambuf_iterator<char>(in), {}};
    const size_t rig = text.find("[rig]"), muscles = text.find("[[muscle]]");
    text.replace(rig, muscles - rig, "[rig]\nfile = \"bones.h5\"\n");
    const size_t skin = text.find("mesh = \"skin.obj\"");
    write("arm/cached.toml", text);
    write("arm/dressed.toml", text.replace(skin, 17, "cache = \"bones.h5\""));
    for (const char* name : {"cached", "dressed"}) {
      bake_to(name, build_model(read_scene(folder / "arm" / (name + std::string(".toml")))),
              frames);
    }
  }
  void bake_to(const std::string& name, const Model& model, const std::vector<int>& frames) {
    BakeOptions options;
    options.folder = folder / name;
    options.frames = frames;
    options.output.double_precision = true;
    fs::create_directories(options.folder);
    bake(model, options, [](const BakeFrame&) { return true; });
  }
  // m, the largest distance of a node of a mesh of the kind from the arm's own.
  double distance(const std::string& name, BakeMesh::Kind kind) {
    const BakeReader a(folder / "whole/bake.h5"), b(folder / name / "bake.h5");
    double most = 0.0;
    for (size_t m = 0; m < a.info().meshes.size(); ++m) {
      if (a.info().meshes[m].kind != kind) continue;
      EXPECT_EQ(a.info().meshes[m].name, b.info().meshes[m].name);
      for (int k = 0; k < kLast; ++k) {
        const auto x = a.read_mesh(k, static_cast<int>(m)), y = b.read_mesh(k, static_cast<int>(m));
        for (size_t i = 0; i < x.size(); ++i) most = std::max(most, (x[i] - y[i]).norm());
      }
    }
    return most;
  }
  // m, over all nodes and frames.
  double rms_of_skin(const std::string& name) {
    const BakeReader a(folder / "whole/bake.h5"), b(folder / name / "bake.h5");
    int skin = 0;
    while (a.info().meshes[skin].kind != BakeMesh::Kind::kSkin) ++skin;
    double sum = 0.0, count = 0.0;
    for (int k = 0; k < kLast; ++k) {
      const auto x = a.read_mesh(k, skin), y = b.read_mesh(k, skin);
      for (size_t i = 0; i < x.size(); ++i) sum += (x[i] - y[i]).squaredNorm(), ++count;
    }
    return std::sqrt(sum / count);
  }
};

TEST_F(CachedArm, IsTheArmItself) {
  using Kind = BakeMesh::Kind;
  EXPECT_LT(distance("cached", Kind::kBone), 1e-13);
  EXPECT_LT(distance("cached", Kind::kMuscle), 1e-9);
  EXPECT_LT(distance("cached", Kind::kSkin), 1e-6);
  // The finished skin as the shape that a skin is carried in: the flesh under it is where it was,
  // and little is left to do.
  EXPECT_LT(distance("dressed", Kind::kMuscle), 1e-9);
  EXPECT_LT(distance("dressed", Kind::kSkin), 2e-3);
  EXPECT_LT(rms_of_skin("dressed"), 1e-4);
}

// A ball of 3 cm comes by a cache and presses a centimetre into the biceps, through the skin.
TEST(BallOnTheArm, IsMetAsABoneIs) {
  const fs::path folder = fs::path(testing::TempDir()) / ("thew_ball_" + std::to_string(getpid()));
  fs::copy(THEW_SOURCE_DIR "/assets/arm", folder, fs::copy_options::recursive);
  fs::copy(THEW_SOURCE_DIR "/tests/scenes/pair/ball.obj", folder / "ball.obj");
  const TriMesh ball = import_closed_mesh(folder / "ball.obj");
  std::ofstream out(folder / "ball.pc2", std::ios::binary);
  const auto put = [&](auto value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
  };
  out.write("POINTCACHE2\0", 12);
  put(std::int32_t{1});
  put(static_cast<std::int32_t>(ball.vertices.size()));
  for (const float value : {1.0f, 15.0f}) put(value);
  put(std::int32_t{2});
  for (const double x : {0.1, 0.058}) {
    for (const Vec3& p : ball.vertices) {
      const Vec3 at = p + Vec3(x, -0.19, 0.015);
      for (int k = 0; k < 3; ++k) put(static_cast<float>(at[k]));
    }
  }
  out.close();
  std::ofstream(folder / "arm.toml", std::ios::app)
      << "\n[[collider]]\nname = \"ball\"\nmesh = \"ball.obj\"\ncache = \"ball.pc2\"\n";
  const Model model = build_model(read_scene(folder / "arm.toml"));
  fs::remove_all(folder);
  Parallel parallel(1);
  StageSeconds seconds;
  State state = initial_state(model);
  settle(model, parallel, state);
  const Points before = state.muscles[0].x;
  for (int f = 1; f <= 15; ++f) step_frame(model, f / model.fps, parallel, state, seconds);
  const Points& at = state.bones.back().x;
  const Surface& surface = model.surfaces.back().surface;
  const Bvh tree = build_bvh(surface, at);
  EXPECT_GT(deepest_inside(surface, tree, at, before), 0.008);
  for (const MuscleState& muscle : state.muscles) {
    EXPECT_EQ(deepest_inside(surface, tree, at, muscle.x), 0.0);
    EXPECT_LT(muscle.volume_error, 1e-12);
  }
  EXPECT_EQ(deepest_inside(surface, tree, at, state.skin.x), 0.0);
  EXPECT_LT(
      std::abs(enclosed_volume(state.skin.x, model.skin.surface.triangles) / model.skin.volume -
               1.0),
      1e-12);
}

}  // namespace
}  // namespace thew::tests
