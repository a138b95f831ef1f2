// SPDX-License-Identifier: Apache-2.0
//
// A bake of quasi_static in chunks, in any order, and their frames joined: the bytes of the whole.
#include <gtest/gtest.h>

#include "rig/text.h"
#include "sim/bake/bake.h"
#include "sim/cache/cache_parts.h"
#include "sim/lone_frame.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/sim/cache_bake.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class LoneFrames : public CacheTest {
 protected:
  Model scene(const std::vector<std::string>& more = {}) {
    std::vector<std::string> settings = {"solver.integrator=quasi_static", "scene.frames=1-12"};
    settings.insert(settings.end(), more.begin(), more.end());
    return build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml", settings));
  }
  static std::vector<int> frames(int first, int last) {
    std::vector<int> list;
    for (int frame = first; frame <= last; ++frame) list.push_back(frame);
    return list;
  }
  BakeOptions options(const std::string& name, const std::vector<int>& wanted) {
    BakeOptions out;
    out.folder = folder_ / name;
    out.frames = wanted;
    return out;
  }
  fs::path chunk(const std::string& name, const std::vector<int>& wanted) {
    BakeOptions how = options(name, wanted);
    how.is_chunk = true;
    bake(model_, how, take_);
    EXPECT_FALSE(fs::exists(how.folder / "bake.h5"));
    return how.folder;
  }
  std::string join(const std::string& name, const std::vector<fs::path>& chunks) {
    join_chunks(model_, options(name, frames(1, 12)), chunks, take_);
    return bytes_of(folder_ / name / "bake.h5");
  }
  std::string whole() {
    bake(model_, options("whole", frames(1, 12)), take_);
    return bytes_of(folder_ / "whole/bake.h5");
  }

  Model model_ = scene();
  OnFrame take_ = [](const BakeFrame&) { return true; };
};

TEST_F(LoneFrames, AreTheSameInAnyChunksAndOrder) {
  const std::string expected = whole();
  ASSERT_FALSE(expected.empty());
  const fs::path second = chunk("second", frames(7, 12)), first = chunk("first", frames(1, 6));
  EXPECT_EQ(join("two", {second, first}), expected);
  std::vector<fs::path> each;
  for (const int frame : {7, 12, 1, 9, 3, 11, 5, 2, 10, 4, 8, 6}) {
    each.push_back(chunk("at" + std::to_string(frame), {frame}));
  }
  EXPECT_EQ(join("each", each), expected);
  each.push_back(first);  // a frame may be there twice
  EXPECT_EQ(join("twice", each), expected);
}

TEST_F(LoneFrames, AResumedBakeIsTheWholeOne) {
  const std::string expected = whole();
  for (const int stop_after : {1, 5, 12}) {
    BakeOptions how = options("resumed", frames(1, 12));
    expect_error(ErrorCode::kRetry, "interrupted", [&] {
      bake(model_, how, [&](const BakeFrame& frame) { return frame.frame < stop_after; });
    });
    how.resume = true;
    const BakeResult result = bake(model_, how, take_);
    EXPECT_EQ(result.resumed_frames, stop_after);
    EXPECT_EQ(bytes_of(how.folder / "bake.h5"), expected);
    fs::remove_all(how.folder);
  }
}

TEST_F(LoneFrames, AStopIsObeyedOnTheWay) {
  BakeOptions how = options("stopped", {12});
  int asked = 0;
  how.stop = [&] { return ++asked == 3; };
  expect_error(ErrorCode::kRetry, "interrupted", [&] { bake(model_, how, take_); });
  EXPECT_EQ(asked, 3);
}

TEST_F(LoneFrames, ChunksThatDoNotFitAreRefused) {
  const fs::path first = chunk("first", frames(1, 6));
  const fs::path gap = chunk("gap", {7, 8, 10, 12});
  expect_error(ErrorCode::kInput, "9,11", [&] { join("joined", {first, gap}); });
  expect_error(ErrorCode::kInput, "of what scene", [&] { join("joined", {first, folder_}); });

  const fs::path last = chunk("last", frames(7, 12));
  const fs::path part = last / "bake.parts" / part_file(9);
  std::string bytes = bytes_of(part);
  bytes[bytes.size() / 2] ^= 1;
  put_bytes(part, bytes);
  expect_error(ErrorCode::kOutput, "frame.0009.part", [&] { join("joined", {first, last}); });

  model_ = scene({"muscle.flexor.material.shape=0.3"});
  const fs::path other = chunk("other", frames(7, 12));
  model_ = scene();
  expect_error(ErrorCode::kUsage, "of another scene", [&] { join("joined", {first, other}); });
}

// A chunk that another version of the program has baked.
TEST_F(LoneFrames, AFrameThatDiffersBetweenChunksIsRefused) {
  const fs::path first = chunk("first", frames(1, 6)), last = chunk("last", frames(6, 12));
  const fs::path manifest = last / "bake.parts" / kManifest;
  std::string text = bytes_of(manifest);
  char& digit = text[text.find("\"hash\":\"") + 8];
  digit = digit == '0' ? '1' : '0';
  put_bytes(manifest, text);
  expect_error(ErrorCode::kInput, "frame 6 is not the same", [&] {
    join("joined", {first, last});
  });
}

}  // namespace
}  // namespace thew::tests
