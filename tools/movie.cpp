// SPDX-License-Identifier: Apache-2.0
#include "tools/movie.h"

#include "sim/durable_file.h"
#include "tools/commands.h"
#include "tools/export_file.h"
#include "tools/program.h"

namespace thew {
namespace {

// ffmpeg's list of files: numbers may have gaps, which its patterns do not allow.
std::string list_of(const std::vector<MoviePicture>& pictures, double fps) {
  std::string list = "ffconcat version 1.0\n";
  for (const MoviePicture& picture : pictures) {
    std::string quoted;
    for (const char c : std::filesystem::absolute(picture.file).string()) {
      quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    list += "file '" + quoted + "'\nduration " + digits(picture.frames / fps) + "\n";
  }
  return list;
}

}  // namespace

std::string write_movie(const std::filesystem::path& file,
                        const std::vector<MoviePicture>& pictures, double fps) {
  const std::filesystem::path list = std::filesystem::path(file) += ".list";
  write_durably(list, list_of(pictures, fps));
  const std::string out = beside(file).string();
  // An even size is what the usual pixel format asks for; "file:" keeps a name with a colon a name.
  const int code = run_program({"ffmpeg",
                                "-nostdin",
                                "-y",
                                "-f",
                                "concat",
                                "-safe",
                                "0",
                                "-i",
                                "file:" + list.string(),
                                "-vf",
                                "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                                "-r",
                                digits(fps),
                                "-c:v",
                                "libx264",
                                "-crf",
                                "18",
                                "-pix_fmt",
                                "yuv420p",
                                "-movflags",
                                "+faststart",
                                "-f",
                                "mp4",
                                "file:" + out});
  remove_durably(list);
  if (code == 0) {
    rename_durably(file);
    return "";
  }
  remove_durably(out);
  stop_if_interrupted();
  if (code == kNotFound) return "";
  return file.string() + ": ffmpeg ended with " + std::to_string(code) +
         " and made no movie; the pictures are there, try it by hand";
}

}  // namespace thew
