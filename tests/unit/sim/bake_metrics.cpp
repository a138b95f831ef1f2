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

}  // namespace
}  // namespace thew::tests
