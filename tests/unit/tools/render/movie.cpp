// SPDX-License-Identifier: Apache-2.0
#include "tools/render/movie.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/unit/rig/temp.h"
#include "tools/render/image.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Movie : public TempFolder {
 protected:
  Movie() : path(std::getenv("PATH")) {
    for (int i = 0; i < 6; i += 2) {
      Image image{33, 21,
                  std::vector<std::uint8_t>(33 * 21 * 3, static_cast<std::uint8_t>(40 * i))};
      pictures.push_back({folder / ("it's." + std::to_string(i) + ".png"), i < 4 ? 2 : 1});
      write_png(pictures.back().file, image);
    }
  }
  ~Movie() override { setenv("PATH", path.c_str(), 1); }
  // A program of the test's own in the place of ffmpeg.
  void put_ffmpeg(const std::string& script) {
    write("bin/ffmpeg", "#!/bin/sh\n" + script + "\n");
    fs::permissions(folder / "bin/ffmpeg", fs::perms::owner_all);
    setenv("PATH", ((folder / "bin").string() + ":" + path).c_str(), 1);
  }
  // But the list of what is ours.
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {})) -
           fs::exists(folder / ".thew.jsonl");
  }

  std::string path;
  std::vector<MoviePicture> pictures;
};

TEST_F(Movie, WithoutFfmpegNothingIsDone) {
  setenv("PATH", folder.c_str(), 1);
  EXPECT_EQ(write_movie(folder / "a.mp4", pictures, 24.0), "");
  EXPECT_EQ(files(), pictures.size());
}

TEST_F(Movie, WhatFailsIsSaidAndLeavesNothing) {
  put_ffmpeg("exit 3");
  EXPECT_HAS(write_movie(folder / "a.mp4", pictures, 24.0), "ffmpeg ended with 3");
  EXPECT_EQ(files(), pictures.size() + 1);
}

TEST_F(Movie, AListNamesEveryPictureInOrder) {
  put_ffmpeg(
      "for word; do last=$word; case $word in file:*) list=${list:-${word#file:}} ;; esac; done\n"
      "cp \"$list\" \"${last#file:}\"");
  EXPECT_EQ(write_movie(folder / "a.mp4", pictures, 25.0), "");
  std::ifstream in(folder / "a.mp4");
  const std::string list((std::istreambuf_iterator<char>(in)), {});
  std::size_t at = 0;
  for (const char* number : {"0", "2", "4"}) {
    at = list.find("it'\\''s." + std::string(number) + ".png'\nduration " +
                       (*number == '4' ? "0.04" : "0.08") + "\n",
                   at);
    EXPECT_NE(at, std::string::npos) << list;
  }
}

TEST_F(Movie, TheRealOneMakesAMovieOfOddSize) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg here";
  EXPECT_EQ(write_movie(folder / "a.mp4", pictures, 24.0), "");
  EXPECT_GT(fs::file_size(folder / "a.mp4"), 500u);
  const std::string count =
      "test $(ffprobe -v error -count_packets -show_entries "
      "stream=nb_read_packets -of csv=p=0 '" +
      (folder / "a.mp4").string() + "') = 5";
  EXPECT_EQ(std::system(count.c_str()), 0);
}

}  // namespace
}  // namespace thew::tests
