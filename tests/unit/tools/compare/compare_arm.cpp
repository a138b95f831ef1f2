// SPDX-License-Identifier: Apache-2.0
//
// The same on the arm: which of twelve muscles it was. Without the skin, frames 1 to 16.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class ComparedArm : public TempFolder {
 protected:
  ComparedArm() {
    fs::copy(THEW_SOURCE_DIR "/assets/arm", folder / "arm", fs::copy_options::recursive);
  }
  fs::path bake(const std::string& name, const std::vector<std::string>& settings = {}) const {
    CommandOptions options;
    options.input = folder / "arm/arm.toml";
    options.out = folder / name;
    options.overrides = settings;
    options.overrides.push_back("skin.enabled=false");
    options.overrides.push_back("scene.frames=\"1-16\"");
    options.progress = "none";
    options.pictures = false;
    bake_command(options);  // its bounds are not at stake here
    return options.out / "bake.h5";
  }
};

TEST_F(ComparedArm, TheMuscleWhoseStiffnessChangedMovedMost) {
  const fs::path a = bake("a");
  EXPECT_TRUE(compare(a, bake("same"), {}).same());
  const fs::path b = bake("b", {"muscle.biceps_long.material.stiffness=1010"});
  const Comparison comparison = compare(a, b, {});
  EXPECT_FALSE(comparison.same());
  EXPECT_EQ(comparison.geometry->meshes.front().name, "biceps_long");
  EXPECT_HAS(comparison_as_text(comparison), "\n  biceps_long moved 0.000");
}

TEST_F(ComparedArm, SwappedMuscles) {
  const fs::path a = bake("a");
  std::ifstream in(folder / "arm/arm.toml");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t one = text.find("name = \"biceps_long\""),
                    two = text.find("name = \"biceps_short\"");
  ASSERT_LT(one, two);
  ASSERT_LT(two, text.size());
  text.replace(two, 21, "name = \"biceps_long\"");
  text.replace(one, 20, "name = \"biceps_short\"");
  write("arm/arm.toml", text);
  EXPECT_HAS(comparison_as_text(compare(a, bake("b"), {})),
             "  biceps_long and biceps_short are swapped\n");
}

}  // namespace
}  // namespace thew::tests
