// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thew::tools {

/// A picture and how many frames it stands for.
struct MoviePicture {
  std::filesystem::path file;
  int frames = 1;
};

/// Pictures as an mp4, by ffmpeg; written beside, renamed and listed as `of`. Says what went wrong,
/// "" for nothing: that ffmpeg is not installed is nothing either, and then no movie is written.
std::string write_movie(const std::filesystem::path& file,
                        const std::vector<MoviePicture>& pictures, double fps,
                        const std::string& of = {});

}  // namespace thew::tools
