// SPDX-License-Identifier: Apache-2.0
//
// What a bake says of depths against the exact tests of thew inspect, which share nothing with it.
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/tools/fit/new.h"
#include "tools/inspect/crossings.h"

namespace thew::tests {
namespace {

using MeasuredDepth = NewScene;

bool counts(const Model& model, const Crossings& found) {
  const int muscles = static_cast<int>(model.muscles.size());
  if (found.deep_mesh < 0 || found.deep_mesh >= muscles || found.deep_in >= model.colliders()) {
    return false;
  }
  const Muscle& muscle = model.muscles[found.deep_mesh];
  const auto& node = muscle.order.node;
  return !muscle.driven[node.empty() ? found.deep_vertex : node[found.deep_vertex]] &&
         !model.ignore[found.deep_mesh][found.deep_in];
}

// The robot's muscles, thin and turned over in places, were said to be 9.99 mm deep in one another:
// the reach within which the sign of a far normal was taken for its word.
TEST_F(MeasuredDepth, IsThatOfTheExactTests) {
  constexpr double kSame = 1e-9;  // m
  int deep = 0;
  const fs::path robot = data("robot.glb");
  std::vector<Found> tried = {{kFigure, 1.0}};
  if (fs::exists(robot)) tried.push_back({robot, 0.4});
  for (const Found& character : tried) {
    ASSERT_EQ(new_command(asked(character.file, "both", character.scale)), ExitCode::kDone);
    const Model model = build_model(read_scene(folder / "character.toml", {}));
    BakeOptions options;
    options.folder = folder / "bake";
    options.frames = {1, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22};
    const std::vector<BakeMesh> meshes = bake_info(model, options.frames).meshes;
    std::vector<std::array<Crossings, kLayerPairs.size()>> found;
    const BakeResult result = bake(model, options, [&](const BakeFrame& frame) {
      found.push_back(find_crossings(meshes, frame.positions));
      return true;
    });
    for (size_t f = 0; f < found.size(); ++f) {
      const auto& [bone, muscle, skin, unused, itself] = found[f];
      const FrameMeasures& said = result.measures[f];
      SCOPED_TRACE(character.file.filename().string() + ", frame " +
                   std::to_string(options.frames[f]));
      EXPECT_LE(said.contact_penetration, std::max(bone.depth, muscle.depth) + kSame);
      for (const Crossings* at : {&bone, &muscle}) {
        if (!counts(model, *at)) continue;
        EXPECT_GE(said.contact_penetration, at->depth - kSame);
        ++deep;
      }
      EXPECT_NEAR(std::max(said.skin.max_penetration, said.skin.max_poke_through), skin.depth,
                  kSame);
    }
    fs::remove_all(options.folder);
  }
  std::printf("%d times deep\n", deep);
  if (!fs::exists(robot)) {
    GTEST_SKIP() << "robot.glb is not there";
  }
}

}  // namespace
}  // namespace thew::tests
