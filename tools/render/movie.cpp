// SPDX-License-Identifier: Apache-2.0
#include "tools/render/movie.h"

#include "sim/cache/durable_file.h"
#include "sim/cache/hash.h"
#include "tools/base/output_file.h"
#include "tools/base/signals.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

constexpr std::size_t kLongestMovie = std::size_t{1} << 34;  // bytes

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
                        const std::vector<MoviePicture>& pictures, double fps,
                        const std::string& of) {
  check_own(file);
  const Temporary list(file), out(file);
  replace_durably(list.path, list_of(pictures, fps));
  // An even size is what the usual pixel format asks for; "file:" keeps a name with a colon a name.
  const int code = run_program({"ffmpeg",
                                "-nostdin",
                                "-y",
                                "-f",
                                "concat",
                                "-safe",
                                "0",
                                "-i",
                                "file:" + list.path.string(),
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
                                "file:" + out.path.string()});
  if (code == 0) {
    const std::string bytes = read_whole_file(out.path, kLongestMovie);
    place_durably(out.path, file, {bytes.size(), hash_of(bytes), of});
    return "";
  }
  stop_if_interrupted();
  if (code == kNotFound) return "";
  return file.string() + ": ffmpeg ended with " + std::to_string(code) +
         " and made no movie; the pictures are there, try it by hand";
}

}  // namespace thew::tools
