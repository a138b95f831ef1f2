// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/property/every.h"
#include "tools/inspect/crossings.h"

namespace thew::tests {
namespace {

// Neither bone and muscle (but where a tendon enters its bone), nor muscles, nor the skin with any
// of them or with itself: by the exact tests of thew inspect, which share nothing with contact and
// take as long as the frame.
void expect_none(const std::string& scene, int step) {
  SCOPED_TRACE(scene);
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/" + scene, {}));
  BakeOptions options;
  options.is_chunk = true;  // nobody reads the cache
  options.folder =
      std::filesystem::path(testing::TempDir()) / ("thew_crossings_" + std::to_string(getpid()));
  for (int f = model.first_frame; f <= model.last_frame; f += step) {
    options.frames.push_back(f);
  }
  const std::vector<BakeMesh> meshes = bake_info(model, options.frames).meshes;
  size_t checked = 0;
  bake(model, options, [&](const BakeFrame& frame) {
    const auto found = count_crossings(meshes, frame.positions);
    for (size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].pairs, 0) << kLayerPairs[k] << ", frame " << frame.frame;
    }
    EXPECT_GT(found[0].attached, 0) << "tendons enter their bones";
    ++checked;
    return true;
  });
  EXPECT_EQ(checked, options.frames.size());
  std::filesystem::remove_all(options.folder);
}

TEST(ArmCrossings, ThereAreNoneInTheFold) { expect_none("arm.toml", 1); }
TEST(ArmCrossings, ThereAreNoneInACurl) { expect_none("curl.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInATurn) { expect_none("turn.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInAReach) { expect_none("reach.toml", every(2)); }
TEST(ArmCrossings, ThereAreNoneInAStill) { expect_none("still.toml", every(2)); }

}  // namespace
}  // namespace thew::tests
