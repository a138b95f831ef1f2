// SPDX-License-Identifier: Apache-2.0
//
// What a bake says of depths against the exact tests of thew inspect, which share nothing with it.
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/property/every.h"
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

// Compares each frame; how often a depth was found that a bake states.
int compare_depths(const Model& model, const fs::path& folder, const std::vector<int>& frames) {
  constexpr double kSame = 1e-9;  // m
  BakeOptions options;
  options.is_chunk = true;  // nobody reads the cache
  options.folder = folder;
  options.frames = frames;
  const std::vector<BakeMesh> meshes = bake_info(model, options.frames).meshes;
  std::vector<std::array<Crossings, kLayerPairs.size()>> found;
  const BakeResult result = bake(model, options, [&](const BakeFrame& frame) {
    found.push_back(find_crossings(meshes, frame.positions));
    return true;
  });
  int deep = 0;
  for (size_t f = 0; f < found.size(); ++f) {
    const auto& [bone, muscle, skin, unused, itself] = found[f];
    const FrameMeasures& said = result.measures[f];
    SCOPED_TRACE(model.source + ", frame " + std::to_string(options.frames[f]));
    EXPECT_LE(said.contact_penetration, std::max(bone.depth, muscle.depth) + kSame);
    for (const Crossings* at : {&bone, &muscle}) {
      if (!counts(model, *at)) continue;
      EXPECT_GE(said.contact_penetration, at->depth - kSame);
      ++deep;
    }
    EXPECT_NEAR(std::max({said.skin.max_penetration, said.skin.max_covered_penetration,
                          said.skin.max_poke_through}),
                skin.depth, kSame);
  }
  fs::remove_all(options.folder);
  return deep;
}

std::vector<int> bending() {  // frames
  if (every(2) == 1) return {1, 7, 8, 10, 12, 14, 16, 18, 20, 22};
  return {1, 8, 13, 18, 22};
}

TEST_F(MeasuredDepth, IsThatOfTheExactTests) {
  ASSERT_EQ(new_command(asked(kFigure, "both", 1.0)), ExitCode::kDone);
  compare_depths(build_model(read_scene(folder / "character.toml", {})), folder / "bake",
                 bending());
}

// The robot's muscles, thin and turned over in places, were said to be 9.99 mm deep in one another:
// the reach within which the sign of a far normal was taken for its word.
TEST_F(MeasuredDepth, IsThatOfTheExactTestsWhereMusclesAreTurnedOver) {
  const fs::path robot = data("robot.glb");
  if (!fs::exists(robot)) GTEST_SKIP() << robot << " is not there";
  ASSERT_EQ(new_command(asked(robot, "both", 0.4)), ExitCode::kDone);
  compare_depths(build_model(read_scene(folder / "character.toml", {})), folder / "bake",
                 bending());
}

// The arm by one iteration of XPBD, which leaves its muscles 2 mm deep in bones and each other.
TEST_F(MeasuredDepth, IsThatOfTheExactTestsWhereMusclesLieDeep) {
  const Model model = build_model(
      read_scene(std::string(THEW_SOURCE_DIR) + "/assets/arm/arm.toml",
                 {"solver.integrator=xpbd", "solver.iterations=1", "skin.enabled=false"}));
  EXPECT_GT(compare_depths(model, folder / "bake", {1, 5, 9, 18, 33, 37, 41}), 0);
}

}  // namespace
}  // namespace thew::tests
