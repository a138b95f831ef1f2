// SPDX-License-Identifier: Apache-2.0
// Two processes that write the same file at the same time: each leaves a whole one, or an error.
#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

class AtOnce : public BakeTest {};

TEST_F(AtOnce, ExportsToOneFile) {
  const fs::path bake = root_ / "whole/bake.h5", out = root_ / "out";
  const auto words = [&](const fs::path& file) {
    return std::vector<std::string>{"export", bake, file, "--progress", "none"};
  };
  for (const char* name : {"a.glb", "a.usdz"}) {
    ASSERT_EQ(CommandProcess(words(root_ / "alone" / name)).wait().code, 0);
    const std::string alone = bytes_of(root_ / "alone" / name);
    ASSERT_GT(alone.size(), 10000u);
    for (int i = 0; i < 8; ++i) {
      CommandProcess first(words(out / name)), second(words(out / name)), third(words(out / name));
      for (CommandProcess* process : {&first, &second, &third}) {
        const auto ended = process->wait();
        EXPECT_EQ(ended.code, 0) << ended.errors;
        EXPECT_TRUE(bytes_of(out / name) == alone) << name << ", time " << i;
      }
      EXPECT_TRUE(temporary_files(out).empty());
    }
  }
}

TEST_F(AtOnce, PicturesIntoOneFolder) {
  const fs::path bake = root_ / "whole/bake.h5", out = root_ / "pictures";
  const auto words = [&](const fs::path& to) {
    return std::vector<std::string>{
        "render",     bake,  "--scene", THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
        "--frames",   "1-4", "--out",   to,
        "--progress", "none"};
  };
  ASSERT_EQ(CommandProcess(words(root_ / "one")).wait().code, 0);
  CommandProcess first(words(out)), second(words(out));
  EXPECT_EQ(first.wait().code, 0) << first.wait().errors;
  EXPECT_EQ(second.wait().code, 0) << second.wait().errors;
  for (int frame = 1; frame <= 4; ++frame) {
    const std::string name = "skin.000" + std::to_string(frame) + ".png";
    EXPECT_TRUE(bytes_of(out / name) == bytes_of(root_ / "one" / name)) << name;
  }
  EXPECT_TRUE(temporary_files(out).empty());
}

}  // namespace
}  // namespace thew::tests
