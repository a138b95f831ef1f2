// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "rig/types.h"
#include "sim/cache/hash.h"

namespace thew::tests {

namespace fs = std::filesystem;

inline std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The command as a process of its own.
struct CommandProcess {
  struct Ended {
    int code = 0;  ///< exit code; -n where signal n ended it
    std::string errors;
  };

  /// `prepare` runs in the process before the command does.
  explicit CommandProcess(std::vector<std::string> words,
                          const std::function<void()>& prepare = {}) {
    static int count = 0;  // beside the bakes: their disk may be full
    errors = fs::path(testing::TempDir()) /
             ("thew_errors_" + std::to_string(getpid()) + "_" + std::to_string(++count));
    words.insert(words.begin(), THEW_COMMAND);
    id = fork();
    if (id != 0) return;
    const int to = open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(to, STDERR_FILENO);
    dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
    if (prepare) prepare();
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    _exit(127);
  }

  ~CommandProcess() {
    wait();
    fs::remove(errors);
  }
  CommandProcess(const CommandProcess&) = delete;

  void send(int signal) const { kill(id, signal); }
  bool ended() {
    if (!over) over = waitpid(id, &status, WNOHANG) == id;
    return over;
  }
  Ended wait() {
    if (!over) waitpid(id, &status, 0);
    over = true;
    std::istringstream all(bytes_of(errors));
    std::string told;  // without warnings of the scene
    for (std::string line; std::getline(all, line);) {
      if (!line.starts_with("thew: warning: ")) told += line + "\n";
    }
    return {WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status), told};
  }

  pid_t id = -1;
  int status = 0;
  bool over = false;
  fs::path errors;
};

/// `thew bake` of the scene `pair`.
struct BakeProcess : CommandProcess {
  explicit BakeProcess(const fs::path& out, const std::vector<std::string>& more = {"--no-render"},
                       const std::function<void()>& prepare = {})
      : CommandProcess(words_of(out, more), prepare) {}

  static std::vector<std::string> words_of(const fs::path& out,
                                           const std::vector<std::string>& more) {
    std::vector<std::string> words = {"bake",       THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml",
                                      "--out",      out.string(),
                                      "--threads",  "2",
                                      "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

/// The frames that the manifest lists, each compared with its file.
inline std::vector<int> kept_frames(const fs::path& out) {
  std::vector<int> frames;
  std::ifstream manifest(out / "bake.parts/manifest.jsonl");
  for (std::string line; std::getline(manifest, line) && !manifest.eof();) {  // not a torn one
    const auto part = nlohmann::json::parse(line);
    const std::string bytes = bytes_of(out / "bake.parts" / part["file"].get<std::string>());
    EXPECT_EQ(bytes.size(), part["bytes"].get<size_t>()) << line;
    EXPECT_EQ(hash_of(bytes), part["hash"].get<std::string>()) << line;
    frames.push_back(part["frame"]);
  }
  return frames;
}

inline bool begins_with(const std::vector<int>& frames, const std::vector<int>& first) {
  return frames.size() >= first.size() && std::equal(first.begin(), first.end(), frames.begin());
}

/// Those of Thew.
inline std::vector<fs::path> temporary_files(const fs::path& out) {
  std::vector<fs::path> found;
  if (!fs::exists(out)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(out)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".tmp") continue;
    if (path.filename().string().starts_with(".thew-") ||
        path.parent_path().filename() == "bake.parts") {
      found.push_back(path);
    }
  }
  return found;
}

/// An uninterrupted bake to compare with, and a folder for each test.
class BakeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    root_ = fs::path(testing::TempDir()) /
            ("thew_" + std::string(testing::UnitTest::GetInstance()->current_test_suite()->name()) +
             "_" + std::to_string(getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_);
    const auto begin = std::chrono::steady_clock::now();
    const auto ended = BakeProcess(root_ / "whole").wait();
    ASSERT_EQ(ended.code, 0) << ended.errors;
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    whole_ = bytes_of(root_ / "whole/bake.h5");
    ASSERT_GT(whole_.size(), 100000u);
  }
  static void TearDownTestSuite() { fs::remove_all(root_); }

  /// A complete bake that equals the uninterrupted one to the bit, and nothing beside it.
  static void expect_whole(const fs::path& out) {
    EXPECT_TRUE(bytes_of(out / "bake.h5") == whole_) << out;
    EXPECT_FALSE(fs::exists(out / "bake.parts"));
    EXPECT_TRUE(temporary_files(out).empty()) << temporary_files(out)[0];
    const auto report = nlohmann::json::parse(bytes_of(out / "report.json"));
    const auto expected = nlohmann::json::parse(bytes_of(root_ / "whole/report.json"));
    EXPECT_EQ(report["hash"], expected["hash"]);
    EXPECT_EQ(report["muscles"], expected["muscles"]);
  }
  static void resume(const fs::path& out) {
    const auto ended = BakeProcess(out, {"--resume", "--no-render"}).wait();
    EXPECT_EQ(ended.code, 0) << ended.errors;
    expect_whole(out);
  }

  static inline fs::path root_;
  static inline std::string whole_;
  static inline double seconds_ = 0.0;  ///< that it took
};

}  // namespace thew::tests
