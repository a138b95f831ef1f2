// SPDX-License-Identifier: Apache-2.0
#include "tools/movie.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "sim/durable_file.h"
#include "tools/commands.h"
#include "tools/export_file.h"

extern char** environ;

namespace thew {
namespace {

// What the shell gives when a program is not there.
constexpr int kNotFound = 127;

// The exit code; the program's output goes nowhere.
int run(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
  }
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return kNotFound;
  int status = 0;
  for (bool told = false;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno != EINTR)) break;
    if (interrupted() && !told) told = ::kill(child, SIGKILL) == 0;
    ::usleep(2000);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

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
  const int code = run({"ffmpeg",
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
  stop_if_interrupted("the pictures are there; run it again for the movie");
  if (code == kNotFound) return "";
  return file.string() + ": ffmpeg ended with " + std::to_string(code) +
         " and made no movie; the pictures are there, try it by hand";
}

}  // namespace thew
