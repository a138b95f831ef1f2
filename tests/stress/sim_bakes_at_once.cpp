// SPDX-License-Identifier: Apache-2.0
// Bakes of one process, each into its folder, while another of its threads reads all the while. A
// reader is a fork: one that was made while a bake held HDF5's lock would wait for it until its
// time is over.
#include <gtest/gtest.h>
#include <thew/thew.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

namespace {

namespace fs = std::filesystem;

TEST(BakesAtOnce, ReadersWaitForNoLockThatTheyCopied) {
  const fs::path folder = fs::path(testing::TempDir()) / "bakes_at_once";
  fs::remove_all(folder);
  const thew::Scene scene = thew::Scene::read(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml",
                                              {"scene.frames=1-4"});
  const fs::path whole = thew::bake(scene, folder / "0");
  const std::string hash = thew::Bake(whole).contents().hash;
  for (const thew::ImportMode mode : {thew::ImportMode::kInProcess, thew::ImportMode::kIsolated}) {
    thew::set_import_mode(mode);
    std::atomic<int> baking{2}, right{0};
    const auto work = [&](const fs::path& out) {
      try {
        for (int turn = 0; turn < 6; ++turn) {
          right += thew::Bake(thew::bake(scene, out)).contents().hash == hash;
        }
      } catch (const thew::Error& error) {
        ADD_FAILURE() << error.what();
      }
      --baking;
    };
    std::thread one(work, folder / "1"), other(work, folder / "2");
    while (baking > 0) EXPECT_NO_THROW(thew::Bake(whole).positions("flexor", 4));
    one.join();
    other.join();
    EXPECT_EQ(right, 12);
  }
}

}  // namespace
