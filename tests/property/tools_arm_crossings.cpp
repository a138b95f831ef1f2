// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "sim/bake.h"
#include "sim/drive.h"
#include "sim/step.h"
#include "tools/inspect_crossings.h"

namespace thew {
namespace {

#ifdef THEW_SANITIZED
constexpr int kStride = 4;
#else
constexpr int kStride = 1;
#endif

// Neither bone and muscle (but where a tendon enters its bone), nor muscles, nor the skin with any
// of them or with itself: by the exact tests of thew inspect, which share nothing with contact.
TEST(ArmCrossings, ThereAreNone) {
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {}));
  const std::vector<BakeMesh> meshes = bake_info(model, {1}).meshes;
  Parallel parallel(2);
  State state = initial_state(model);
  settle(model, parallel, state);
  StageSeconds unused;
  const int first = model.scene.first_frame;
  for (int f = first; f <= model.scene.last_frame; f += kStride) {
    if (f > first) step_frame(model, (f - first) / model.scene.fps, parallel, state, unused);
    refit_all(model, parallel, state);
    std::vector<std::vector<Vec3>> positions;
    const auto add = [&](const Rows& x) {
      std::vector<Vec3>& points = positions.emplace_back();
      for (const Row& p : x) points.push_back(to_vec(p));
    };
    for (const MuscleState& muscle : state.muscles) add(muscle.x);
    for (const BoneState& bone : state.bones) add(bone.x);
    add(state.skin.x);
    ASSERT_EQ(positions.size(), meshes.size());
    const auto found = find_crossings(meshes, positions);
    for (size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].pairs, 0) << kLayerPairs[k] << ", frame " << f;
    }
    EXPECT_GT(found[0].attached, 0) << "tendons enter their bones";
  }
}

}  // namespace
}  // namespace thew
