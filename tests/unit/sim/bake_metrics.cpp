// SPDX-License-Identifier: Apache-2.0
// What a bake states of its frames beside positions, against what it was given.
#include <gtest/gtest.h>

#include "muscles/weights.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

class BakeMetrics : public TempFolder {};

TEST_F(BakeMetrics, HaveTheActivationOfEachFrame) {
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml"));
  BakeOptions options;
  options.folder = folder;
  options.frames = {1, 3, 5, 12};
  bake(model, options, [](const BakeFrame&) { return true; });
  const BakeReader bake(folder / "bake.h5");
  const std::vector<std::string>& names = bake.info().metric_names;
  const auto metric = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    EXPECT_NE(found, names.end()) << name;
    return bake.metric(static_cast<int>(found - names.begin()));
  };
  for (size_t k = 0; k < options.frames.size(); ++k) {
    const double wanted = keyed_value(model.muscles[0].settings.activation, options.frames[k]);
    EXPECT_NEAR(metric("activation/front")[k], wanted, 1e-12) << options.frames[k];
    EXPECT_EQ(metric("activation/side")[k], 0.0);
  }
  EXPECT_GT(metric("activation/front")[2], 0.4);
}

// From where the origin is to where the insertion is, and as long as the path.
TEST_F(BakeMetrics, HaveTheLineOfActionOfEachFrame) {
  const Model model =
      build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml"));
  BakeOptions options;
  options.folder = folder;
  options.frames = {1, 7, 13};
  bake(model, options, [](const BakeFrame&) { return true; });
  const BakeReader bake(folder / "bake.h5");
  const Muscle& muscle = model.muscles[0];
  const auto& meshes = bake.info().meshes;
  const auto m = static_cast<size_t>(
      std::find_if(meshes.begin(), meshes.end(),
                   [&](const BakeMesh& mesh) { return mesh.name == muscle.name; }) -
      meshes.begin());
  ASSERT_EQ(meshes.at(m).line, 33u);
  const auto& names = bake.info().metric_names;
  const auto length = static_cast<int>(
      std::find(names.begin(), names.end(), "length/" + muscle.name) - names.begin());
  std::vector<Vec3> first;
  for (int i = 0; i < 3; ++i) {
    const BakeFrame frame = bake.read(i);
    const std::vector<Vec3>& line = frame.lines[m];
    ASSERT_EQ(line.size(), 33u);
    std::vector<double> joints;
    sample_clip(model.clip, model.skeleton, (options.frames[i] - model.first_frame) / model.fps,
                joints);
    Pose pose;
    forward_kinematics(model.skeleton, joints, pose);
    const auto& path = muscle.shape.path.points;
    EXPECT_LT((line.front() - pose[path.front().body] * path.front().position).norm(), 1e-6);
    EXPECT_LT((line.back() - pose[path.back().body] * path.back().position).norm(), 1e-6);
    double sum = 0.0;
    for (size_t k = 1; k < line.size(); ++k) sum += (line[k] - line[k - 1]).norm();
    EXPECT_LE(sum, bake.metric(length)[i] + 1e-6);
    EXPECT_GT(sum, 0.95 * bake.metric(length)[i]);  // corners are rounded
    if (i == 0) first = line;
  }
  EXPECT_GT((bake.read(2).lines[m].back() - first.back()).norm(), 0.01);  // it moves
}

}  // namespace
}  // namespace thew::tests
