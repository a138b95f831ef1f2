// SPDX-License-Identifier: Apache-2.0
//
// The same of the other commands: exports, turntables, goldens, new scenes, repairs, pages.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "sim/cache/own_files.h"
#include "sim/scene/reader.h"
#include "tests/unit/tools/export/export.h"
#include "tests/unit/tools/fit/new.h"
#include "tools/compare/golden_files.h"
#include "tools/inspect/draw_maps.h"
#include "tools/inspect/repair.h"
#include "tools/render/image.h"

namespace thew::tests {
namespace {

class OwnExport : public ExportTest {
 protected:
  const std::vector<std::string> mesh_ = {"biceps"};
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ / "e")) {
      if (entry.path().filename() != ".thew.jsonl") names.push_back(entry.path().filename());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(OwnExport, ReplacesItsOwnAndNobodyElses) {
  bake(false);
  const struct {
    const char *file, *writes;
  } cases[] = {{"e/a.pc2", "a.pc2"},      {"e/a.pc2", "a.rest.obj"}, {"e/a.mdd", "a.mdd"},
               {"e/a.obj", "a.0004.obj"}, {"e/a.obj", "a.mtl"},      {"e/a.###.ply", "a.002.ply"},
               {"e/a.glb", "a.glb"},      {"e/a.xdmf", "a.xdmf"},    {"e/a.usda", "a.usda"},
               {"e/a.usdc", "a.usdc"},    {"e/a.usdz", "a.usdz"},    {"e/a.abc", "a.abc"}};
  for (const auto& [file, writes] : cases) {
    SCOPED_TRACE(writes);
    fs::remove_all(folder_ / "e");
    fs::create_directories(folder_ / "e");
    const fs::path mine = folder_ / "e" / writes;
    put_bytes(mine, "mine");
    options_.out = folder_ / file;
    expect_error(ErrorCode::kOutput, "not of Thew's making",
                 [&] { export_command(options_, mesh_, 0); });
    EXPECT_EQ(names(), std::vector<std::string>{writes});  // it ended before it wrote anything
    EXPECT_EQ(bytes_of(mine), "mine");
    options_.overwrite = true;
    write(file, mesh_);
    options_.overwrite = false;
    const std::string exported = bytes_of(mine);
    EXPECT_NE(exported, "mine");
    write(file, mesh_);
    EXPECT_EQ(bytes_of(mine), exported);
    fs::remove(mine);
    fs::create_symlink("/dev/null", mine);
    for (const bool overwrite : {false, true}) {
      options_.overwrite = overwrite;
      expect_error(ErrorCode::kOutput, "symbolic link",
                   [&] { export_command(options_, mesh_, 0); });
    }
    options_.overwrite = false;
  }
}

// The list of what is ours may grow by two lines: the third file fails, the first two go again.
TEST_F(OwnExport, ASequenceThatFailsLeavesNothing) {
  bake(false);
  for (const char* file : {"e/a.obj", "e/a.ply"}) {
    fs::remove_all(folder_ / "e");
    write(file, mesh_);
    for (const std::string& name : names()) fs::remove(folder_ / "e" / name);
    put_bytes(folder_ / "e/a.9999.obj", "mine");
    options_.out = folder_ / file;
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_IGN);
    const auto list = fs::file_size(folder_ / "e/.thew.jsonl");
    const rlimit limit{static_cast<rlim_t>(list) + 250, before.rlim_max};  // of the list: 2 lines
    setrlimit(RLIMIT_FSIZE, &limit);
    expect_error(ErrorCode::kOutput, "cannot write", [&] { export_command(options_, mesh_, 0); });
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(names(), std::vector<std::string>{"a.9999.obj"}) << file;
  }
}

TEST_F(NewScene, OverwritesNoMeshButItsOwnUntouchedOnes) {
  NewOptions options = asked(kFigure, "left");
  options.force = false;
  const fs::path mesh = folder / "muscles/brachialis_left.obj";
  const auto expect_refused = [&](const char* word, const std::string& bytes) {
    expect_error(ErrorCode::kOutput, word, [&] { new_command(options); });
    EXPECT_EQ(bytes_of(mesh), bytes);
    EXPECT_FALSE(fs::exists(options.out));
  };
  write("muscles/brachialis_left.obj", "mine");
  expect_refused("not of Thew's making", "mine");
  fs::remove(mesh);
  EXPECT_EQ(new_command(options), ExitCode::kDone);
  const std::string made = bytes_of(mesh);
  // Its scene again, once that was removed ...
  fs::remove(options.out);
  EXPECT_EQ(new_command(options), ExitCode::kDone);
  // ... but neither another scene over its meshes, nor over what was edited.
  options.out = folder / "other.toml";
  expect_refused("of another scene", made);
  options.out = folder / "character.toml";
  fs::remove(options.out);
  put_bytes(mesh, made + "# touched\n");
  expect_refused("edited since", made + "# touched\n");
  options.force = true;
  EXPECT_EQ(new_command(options), ExitCode::kDone);
  EXPECT_EQ(bytes_of(mesh), made);
}

TEST_F(NewScene, WritesThroughNoLink) {
  NewOptions options = asked(kFigure, "left");
  fs::create_directories(folder / "elsewhere");
  fs::create_directory_symlink(folder / "elsewhere", folder / "muscles");
  expect_error(ErrorCode::kOutput, "symbolic link", [&] { new_command(options); });
  EXPECT_TRUE(fs::is_empty(folder / "elsewhere"));
}

class OwnGolden : public TempFolder {
 protected:
  OwnGolden() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/one_muscle", folder / "scene");
    options.input = folder / "scene/scene.toml";
    options.out = folder / "out";
    options.progress = "none";
    options.threads = 1;
    options.frames = "1";
    options.overrides = {"render.size=[64, 36]"};
  }
  void update() {
    testing::internal::CaptureStdout();
    try {
      golden_update_command(options, folder / "golden");
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    testing::internal::GetCapturedStdout();
  }
  CommandOptions options;
};

TEST_F(OwnGolden, EmptiesNoFolderAndReplacesNoBake) {
  write_png(folder / "a.png", {2, 2, std::vector<std::uint8_t>(12, 99)});
  const std::string mine = bytes_of(folder / "a.png");
  write("out/frames/mine.png", mine);
  write("out/frames/muscles.final.png", mine);
  update();
  EXPECT_FALSE(fs::exists(folder / "golden/frames/mine.png"));
  write("golden/frames/mine.png", mine);
  options.frames = "2";
  update();
  EXPECT_FALSE(fs::exists(folder / "golden/frames/muscles.0001.png"));
  EXPECT_FALSE(fs::exists(folder / "out/frames/muscles.0001.png"));
  for (const char* name :
       {"out/frames/mine.png", "out/frames/muscles.final.png", "golden/frames/mine.png"}) {
    EXPECT_EQ(bytes_of(folder / name), mine) << name;
  }
  // A picture of a user's in the place of a golden to come, and a bake where there are no goldens.
  write("golden/frames/muscles.0003.png", mine);
  options.frames = "3";
  expect_error(ErrorCode::kOutput, "not of Thew's making", [&] { update(); });
  EXPECT_EQ(bytes_of(folder / "golden/frames/muscles.0003.png"), mine);
  EXPECT_TRUE(fs::exists(folder / "golden/frames/muscles.0002.png"));
  fs::remove(folder / "golden/golden.json");
  expect_error(ErrorCode::kOutput, "golden/bake.h5", [&] { update(); });
  options.overwrite = true;
  update();
  EXPECT_EQ(read_recipe(folder / "golden").frames, "3");
}

TEST_F(OwnGolden, WritesThroughNoLink) {
  fs::create_directories(folder / "elsewhere");
  for (const char* name : {"golden", "out"}) {
    fs::create_directories(folder / name);
    fs::create_directory_symlink(folder / "elsewhere", folder / name / "frames");
    expect_error(ErrorCode::kOutput, "symbolic link", [&] { update(); });
    EXPECT_TRUE(fs::is_empty(folder / "elsewhere")) << name;
    fs::remove_all(folder / name);
  }
}

using OwnRepair = TempFolder;

TEST_F(OwnRepair, NeverWritesOntoWhatItReads) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  const fs::path mesh = write("open.obj", text);
  fs::create_symlink(mesh, folder / "link.obj");
  fs::create_hard_link(mesh, folder / "hard.obj");
  for (const fs::path& out :
       {mesh, folder / "./open.obj", folder / "link.obj", folder / "hard.obj"}) {
    expect_error(ErrorCode::kUsage, "itself", [&] { repair_file(mesh, out, true); });
    EXPECT_EQ(bytes_of(mesh), text);
  }
  const fs::path other = write("other.obj", "mine");
  expect_error(ErrorCode::kOutput, "not of Thew's making", [&] { repair_file(mesh, other); });
  EXPECT_EQ(bytes_of(other), "mine");
  EXPECT_FALSE(repair_file(mesh, folder / "new.obj").empty());
  EXPECT_FALSE(repair_file(mesh, folder / "new.obj").empty());  // its own again
  EXPECT_FALSE(repair_file(mesh, other, true).empty());
  EXPECT_NE(bytes_of(other), "mine");
}

using OwnMaps = TempFolder;

TEST_F(OwnMaps, ReplaceNoPictureOfTheUsers) {
  const Scene scene = read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml");
  const fs::path mine = write("maps/flexor.weights.png", "mine");
  expect_error(ErrorCode::kOutput, "not of Thew's making",
               [&] { draw_maps(scene, folder / "maps", false); });
  EXPECT_EQ(bytes_of(mine), "mine");
  for (const bool overwrite : {true, false}) {  // its own again
    EXPECT_EQ(draw_maps(scene, folder / "maps", overwrite).size(), 1u);
    EXPECT_NE(bytes_of(mine), "mine");
  }
}

}  // namespace
}  // namespace thew::tests
