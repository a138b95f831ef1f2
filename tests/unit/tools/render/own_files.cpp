// SPDX-License-Identifier: Apache-2.0
//
// Nobody else's files are touched, nothing completed is thrown away, and what is kept is what it is
// taken for.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/bake/bake.h"
#include "sim/cache/durable_file.h"
#include "sim/cache/hash.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/cache_bake.h"
#include "tools/cli/commands.h"
#include "tools/render/image.h"
#include "tools/render/pictures.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

TEST(OwnFiles, AreThoseOfTheLastWholeLine) {
  const fs::path folder = fs::path(testing::TempDir()) / "thew_own_lines";
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const char* name : {"a", "with \"quotes\" and \\", "two\nlines", "\xff no UTF-8"}) {
    EXPECT_FALSE(own_file(folder / name)) << name;
    write_durably(folder / name, "bytes", "key");
    EXPECT_EQ(own_file(folder / name).value().of, "key") << name;
    EXPECT_EQ(own_file(folder / name).value().hash, hash_of("bytes"));
  }
  write_durably(folder / "a", "longer", "other");
  EXPECT_EQ(own_file(folder / "a").value().bytes, 6u);
  const std::string list = bytes_of(folder / ".thew.jsonl");
  for (std::size_t cut = list.rfind('\n', list.size() - 2) + 1; cut < list.size(); ++cut) {
    put_bytes(folder / ".thew.jsonl", list.substr(0, cut));
    EXPECT_EQ(own_file(folder / "a").value().of, "key") << "torn at " << cut;
    write_durably(folder / "b", "after a torn line");
    EXPECT_TRUE(own_file(folder / "b"));
    remove_own(folder / "b");
    EXPECT_FALSE(own_file(folder / "b"));
    EXPECT_FALSE(fs::exists(folder / "b"));
  }
  put_bytes(folder / "b", "mine");  // since it was removed, ours no more
  expect_error(ErrorCode::kOutput, "not of Thew's making",
               [&] { write_durably(folder / "b", ""); });
  remove_own(folder / "b");
  EXPECT_EQ(bytes_of(folder / "b"), "mine");
  fs::remove_all(folder);
}

class Own : public TempFolder {
 protected:
  Own() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/pair", folder / "scene", fs::copy_options::recursive);
    options.input = folder / "scene/scene.toml";
    options.out = folder / "out";
    options.progress = "none";
    options.threads = 1;
    options.frames = "1-3";
  }
  ExitCode bake() {
    testing::internal::CaptureStderr();
    struct Said {
      std::string& to;
      ~Said() { to = testing::internal::GetCapturedStderr(); }
    } said_now{said};
    return bake_command(options);
  }
  void expect_refused(const std::string& word, ErrorCode code = ErrorCode::kOutput) {
    expect_error(code, word, [&] { bake(); });
  }
  // A bake of frames 1 to 3 that was interrupted after so many.
  void interrupt_after(int frames) {
    const Model model = build_model(read_scene(options.input, options.overrides));
    EXPECT_THROW(sim::bake(model, {options.out, {1, 2, 3}, 1, false},
                           [&](const BakeFrame& frame) { return frame.frame < frames; }),
                 Error);
  }
  ino_t number_of(const fs::path& file) const {
    struct stat about {};
    return ::stat(file.c_str(), &about) == 0 ? about.st_ino : 0;
  }
  fs::path picture(int frame) const {
    return options.out / "frames" / ("skin.000" + std::to_string(frame) + ".png");
  }

  CommandOptions options;
  std::string said;
};

TEST_F(Own, FilesOfAUserStay) {
  const std::vector<std::string> mine = {
      "out/notes.txt",           "out/bake.h5.tmp",           "out/frames/muscles.png",
      "out/frames/skin.png",     "out/frames/skin.final.png", "out/frames/skin.reference.png",
      "out/frames/skin.a/x.png", "out/frames/skin.0004.png",  "out/bake.parts/notes.txt"};
  bake();
  for (const std::string& name : mine) write(name, "mine");
  options.frames = "1-2";
  options.overwrite = true;
  EXPECT_EQ(bake(), ExitCode::kDone);
  options.overrides = {"solver.iterations=4"};
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_FALSE(fs::exists(picture(3)));  // of the bake that is no more
  CommandOptions render = options;
  render.input = options.out / "bake.h5";
  render.out = options.out / "frames";
  render.overrides = {"render.size=[64, 36]"};
  EXPECT_EQ(render_command(render, options.input), ExitCode::kDone);
  for (const std::string& name : mine) EXPECT_EQ(bytes_of(folder / name), "mine") << name;
}

TEST_F(Own, WhatIsInTheWayIsToldBeforeAnythingIsDone) {
  for (const char* name : {"bake.h5", "report.json", "report.html", "failure.json",
                           "frames/skin.0003.png", "frames/contact_sheet.png", "frames/skin.mp4"}) {
    SCOPED_TRACE(name);
    fs::remove_all(options.out);
    write(std::string("out/") + name, "mine");
    expect_refused("not of Thew's making");
    EXPECT_EQ(bytes_of(options.out / name), "mine");
    EXPECT_FALSE(fs::exists(options.out / "bake.parts"));
    options.overwrite = true;
    if (std::string(name).ends_with("json") || std::string(name).ends_with("3.png")) {
      EXPECT_EQ(bake(), ExitCode::kDone);
      EXPECT_NE(bytes_of(options.out / name), "mine");
    }
    // A folder of that name is left alone whatever is given.
    fs::remove_all(options.out);
    write(std::string("out/") + name + "/file", "mine");
    expect_refused(name);
    EXPECT_EQ(bytes_of(options.out / name / "file"), "mine");
    options.overwrite = false;
  }
  fs::remove_all(options.out);
  write("out/bake.parts/frame.0001.part", "mine");
  expect_refused("not of Thew's making");
  EXPECT_EQ(bytes_of(options.out / "bake.parts/frame.0001.part"), "mine");
}

TEST_F(Own, NothingIsWrittenThroughALink) {
  fs::create_directories(folder / "elsewhere");
  for (const char* name : {"frames", "bake.parts"}) {
    fs::create_directories(options.out);
    fs::create_directory_symlink(folder / "elsewhere", options.out / name);
    for (options.overwrite = false;; options.overwrite = true) {
      expect_refused("symbolic link");
      if (options.overwrite) break;
    }
    EXPECT_TRUE(fs::is_empty(folder / "elsewhere")) << name;
    fs::remove_all(options.out);
  }
}

TEST_F(Own, ASecondBakeThrowsNothingAway) {
  options.pictures = false;
  interrupt_after(2);
  const ino_t part = number_of(options.out / "bake.parts/frame.0001.part");
  options.overrides = {"solver.iterations=4"};
  expect_refused("a setting of scene, solver, contact or skin has changed");
  options.overrides.clear();
  for (const bool resume : {false, true}) {
    options.resume = resume;
    options.frames = "2-3";
    expect_refused("2 frames, 1 to 2, completed", resume ? ErrorCode::kUsage : ErrorCode::kOutput);
  }
  options.resume = false;
  EXPECT_EQ(number_of(options.out / "bake.parts/frame.0001.part"), part);
  options.frames = "1-3";
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "goes on from 2 completed frames; --overwrite bakes anew");

  const ino_t whole = number_of(options.out / "bake.h5");
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "is complete; nothing to do, --overwrite bakes anew");
  for (const char* setting :
       {"solver.iterations=4", "scene.name=other", "output.precision=single"}) {
    options.overrides = {setting};
    for (const bool resume : {false, true}) {
      options.resume = resume;
      expect_refused("bake anew with --overwrite", resume ? ErrorCode::kUsage : ErrorCode::kOutput);
    }
  }
  options.resume = false;
  options.overrides.clear();
  options.frames = "1-2";
  expect_refused("there are 3 frames, 1 to 3, and asked for are 2 frames, 1 to 2");
  EXPECT_EQ(number_of(options.out / "bake.h5"), whole);
  options.overwrite = true;
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_EQ(BakeReader(options.out / "bake.h5").info().frames.size(), 2u);
}

// A bake that was to replace another, and was killed: each goes on from what is its own.
TEST_F(Own, ACompleteBakeAndPartsOfAnotherStandSideBySide) {
  options.pictures = false;
  bake();
  const std::vector<std::string> other = {"solver.iterations=4"};
  options.overrides = other;
  interrupt_after(2);
  options.overrides.clear();
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "is complete");
  options.overrides = other;
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "goes on from 2");
}

TEST_F(Own, ABakeOfAVersionWithoutAListIsKnownByWhatItIs) {
  options.pictures = false;
  bake();
  fs::remove(options.out / ".thew.jsonl");
  for (const char* name : {"report.json", "report.html"}) fs::remove(options.out / name);
  const ino_t whole = number_of(options.out / "bake.h5");
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_EQ(number_of(options.out / "bake.h5"), whole);
}

TEST_F(Own, APictureIsKeptOnlyWhereItIsWhatItIsTakenFor) {
  bake();
  std::map<int, std::string> good;
  std::map<int, ino_t> number;
  for (const int frame : {1, 2, 3}) {
    good[frame] = bytes_of(picture(frame));
    ASSERT_GT(good[frame].size(), 1000u);
  }
  const auto expect_only_second_drawn = [&](const char* what) {
    SCOPED_TRACE(what);
    number = {{1, number_of(picture(1))}, {3, number_of(picture(3))}};
    EXPECT_EQ(bake(), ExitCode::kDone);
    for (const int frame : {1, 2, 3}) EXPECT_TRUE(bytes_of(picture(frame)) == good[frame]);
    for (const int frame : {1, 3}) EXPECT_EQ(number_of(picture(frame)), number[frame]);
  };
  put_bytes(picture(2), good[2].substr(0, good[2].size() / 2));
  expect_only_second_drawn("cut");
  put_bytes(picture(2), std::string(good[2]).replace(good[2].size() - 30, 1, "x"));
  expect_only_second_drawn("a byte changed");
  put_bytes(picture(2), good[1]);
  expect_only_second_drawn("of another frame");
  write_png(picture(2), read_png(picture(1)));  // listed, but as nothing
  expect_only_second_drawn("of nothing that is known");
  fs::remove(picture(2));
  expect_only_second_drawn("gone");

  const ino_t first = number_of(picture(1));
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "is complete");
  EXPECT_EQ(number_of(picture(1)), first);
  options.overrides = {"render.size=[80, 45]"};
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_EQ(read_png(picture(3)).width, 80);
}

// Whichever frames a process has at hand, the scene alone says where the camera stands.
TEST_F(Own, AFollowingCameraIsTheSameWhicheverFramesAreDrawn) {
  std::string scene = bytes_of(options.input);
  const std::string eye = "eye = [0.3, -0.2, 1.6]\ntarget = [0, -0.3, 0]\n";
  ASSERT_NE(scene.find(eye), std::string::npos);
  put_bytes(options.input, scene.replace(scene.find(eye), eye.size(),
                                         "from = [0.2, 0.1, 1]\nfollow = \"ulna\"\n"));
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_NE(bytes_of(picture(1)), bytes_of(picture(3)));
  CommandOptions render = options;
  render.input = options.out / "bake.h5";
  render.out = folder / "drawn";
  render.chunk = true;
  for (const char* frame : {"3", "2"}) {
    render.frames = frame;
    EXPECT_EQ(render_command(render, options.input), ExitCode::kDone);
  }
  const fs::path whole = options.out / "frames";
  options.out = folder / "alone";
  options.frames = "2";
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_EQ(bytes_of(folder / "drawn/skin.0003.png"), bytes_of(whole / "skin.0003.png"));
  for (const fs::path& other : {folder / "drawn", folder / "alone/frames"}) {
    EXPECT_EQ(bytes_of(other / "skin.0002.png"), bytes_of(whole / "skin.0002.png")) << other;
  }
  // Pictures of other cameras are drawn anew; a body that is not there is told.
  const std::string before = bytes_of(picture(2));
  options.overrides = {"render.view.skin.follow=humerus"};
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_NE(bytes_of(picture(2)), before);
  options.overrides = {"render.view.skin.follow=ulnar"};
  expect_refused(
      "view \"skin\" follows \"ulnar\", which is no body of the rig; did you mean "
      "\"ulna\"",
      ErrorCode::kUsage);
}

TEST_F(Own, PicturesOfAnotherVersionAreDrawnAgainAndItsOthersRemoved) {
  options.pictures = false;
  bake();
  const BakeReader reader(options.out / "bake.h5");
  const std::vector<SceneView> views = views_of(reader);
  const auto missing = [&](const char* program, const std::string& bake) {
    Pictures pictures(folder / "p", bake, 64, 36, views, reader.info().meshes, program);
    std::size_t count = 0;
    for (int i = 0; i < 3; ++i) count += pictures.keep(reader.read(i)).size();
    return count;
  };
  const auto draw = [&](const char* program, const std::string& bake, int frames) {
    Pictures pictures(folder / "p", bake, 64, 36, views, reader.info().meshes, program);
    for (int i = 0; i < frames; ++i) pictures.draw(reader.read(i));
    pictures.finish();
  };
  const std::size_t all = 3 * views.size();
  EXPECT_EQ(missing("1", "a"), all);
  draw("1", "a", 3);
  EXPECT_EQ(missing("1", "a"), 0u);
  EXPECT_EQ(missing("2", "a"), all);
  EXPECT_EQ(missing("1", "b"), 0u);  // another bake that comes to the same
  draw("2", "a", 1);
  EXPECT_EQ(missing("2", "a"), all - views.size());
  EXPECT_FALSE(fs::exists(folder / "p/skin.0002.png"));
  EXPECT_TRUE(fs::exists(folder / "p/skin.0001.png"));
}

// What fails on the drawing thread: a frame or two later, or at the end.
TEST_F(Own, AnErrorOfDrawingReachesWhoAsksForPictures) {
  options.pictures = false;
  bake();
  const BakeReader reader(options.out / "bake.h5");
  std::vector<SceneView> views = views_of(reader);
  views.back().target = views.back().eye;
  const auto message = [&](int frames, bool finished) {
    Pictures pictures(folder / "p", "a", 64, 36, views, reader.info().meshes);
    try {
      for (int i = 0; i < frames; ++i) pictures.draw(reader.read(i % 3));
      if (finished) pictures.finish();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const char* expected = "view \"weights\": eye and target coincide; move one of them";
  EXPECT_EQ(message(1, true), expected);
  EXPECT_EQ(message(2 + static_cast<int>(Pictures::kQueuedFrames), false), expected);
  EXPECT_EQ(message(1, false), "no error");  // whoever gives up is not held up
}

TEST_F(Own, AFailureEndsWithTheNextSuccess) {
  options.pictures = false;
  // As a bake leaves it that ends with 5 (stress_sim_faults makes such).
  const auto fail = [&] { write_durably(options.out / "failure.json", "{}\n"); };
  fs::create_directories(options.out);
  fail();
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_FALSE(fs::exists(options.out / "failure.json"));
  fail();  // of one that was to replace this
  EXPECT_EQ(bake(), ExitCode::kDone);
  EXPECT_HAS(said, "is complete");
  EXPECT_FALSE(fs::exists(options.out / "failure.json"));
}

}  // namespace
}  // namespace thew::tests
