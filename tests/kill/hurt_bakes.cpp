// SPDX-License-Identifier: Apache-2.0
// Bakes onto disks that are full, broken, read-only or not what they seem: hurt_bakes [POINTS]
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

int points = 4;
bool may_mount = false;

class Hurt : public BakeTest {
 protected:
  // It ended with one error that says what to do, kept what it had, and goes on from there.
  static void expect_told(const fs::path& out, const BakeProcess::Ended& ended,
                          const std::string& word) {
    EXPECT_EQ(ended.code, 4) << ended.errors;
    EXPECT_EQ(std::count(ended.errors.begin(), ended.errors.end(), '\n'), 1) << ended.errors;
    EXPECT_TRUE(ended.errors.starts_with("thew: ")) << ended.errors;
    EXPECT_NE(ended.errors.find(word), std::string::npos) << ended.errors;
    EXPECT_TRUE(temporary_files(out).empty()) << temporary_files(out)[0];
    const std::vector<int> frames = kept_frames(out);
    for (size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(frames[i], static_cast<int>(i) + 1);
  }
};

/// A small disk of its own, seen by this process and its children alone.
struct Disk {
  Disk(const fs::path& at, uintmax_t bytes) : folder(at) {
    fs::create_directories(folder);
    good = mount("none", folder.c_str(), "tmpfs", 0, size(bytes).c_str()) == 0;
  }
  ~Disk() {
    if (good) umount2(folder.c_str(), MNT_DETACH);
  }
  bool change(uintmax_t bytes, unsigned long flags = 0) const {
    return mount("none", folder.c_str(), "tmpfs", MS_REMOUNT | flags, size(bytes).c_str()) == 0;
  }
  static std::string size(uintmax_t bytes) { return "size=" + std::to_string(bytes); }

  fs::path folder;
  bool good = false;
};

TEST_F(Hurt, AFullDiskCostsNothingThatWasDone) {
  if (!may_mount) GTEST_SKIP() << "no permission to mount a small disk";
  // All parts, and bake.h5 beside them: a bake that has no room to pack keeps its parts.
  const rlimit limit{whole_.size() - 1, RLIM_INFINITY};
  const auto set_limit = [&] { setrlimit(RLIMIT_FSIZE, &limit); };
  expect_told(root_ / "parts", BakeProcess(root_ / "parts", {"--no-render"}, set_limit).wait(),
              "free some space");
  uintmax_t most = whole_.size();
  for (const auto& part : fs::directory_iterator(root_ / "parts/bake.parts")) {
    most += part.file_size();
  }
  int told = 0;
  size_t fewest = 1000, largest = 0;
  for (int i = 1; i <= points; ++i) {
    const Disk disk(root_ / ("disk" + std::to_string(i)), most * i / (points + 1));
    ASSERT_TRUE(disk.good);
    const fs::path out = disk.folder / "out";
    const auto ended = BakeProcess(out).wait();
    if (ended.code == 0) continue;
    ++told;
    expect_told(out, ended, "free some space");
    const size_t frames = kept_frames(out).size();
    fewest = std::min(fewest, frames), largest = std::max(largest, frames);
    ASSERT_TRUE(disk.change(10 * most));
    resume(out);
  }
  std::printf("%d of %d disks were full, after %zu to %zu frames\n", told, points, fewest, largest);
  EXPECT_GT(told, points / 2);
}

TEST_F(Hurt, ALimitOnTheSizeOfFilesIsTold) {
  for (int i = 0; i < points; ++i) {
    const fs::path out = root_ / ("limit" + std::to_string(i));
    const rlimit limit{static_cast<rlim_t>(whole_.size() * i / points), RLIM_INFINITY};
    const auto set_limit = [&] { setrlimit(RLIMIT_FSIZE, &limit); };
    auto ended = BakeProcess(out, {"--no-render"}, set_limit).wait();
    if (i == 0) ended.errors = "thew: free some space\n";  // nor could that be written
    expect_told(out, ended, "free some space");
    resume(out);
  }
}

TEST_F(Hurt, AnErrorOfTheDiskIsTold) {
  const auto bake = [&](const fs::path& out, int at, bool on) {
    return BakeProcess(out, {"--no-render"},
                       [&] {
                         setenv("LD_PRELOAD", THEW_FAILING_IO, 1);
                         setenv("THEW_FAIL_BELOW", (out.string() + "/").c_str(), 1);
                         setenv("THEW_FAIL_AT", std::to_string(at).c_str(), 1);
                         setenv("THEW_FAIL_COUNT", (root_ / "count").c_str(), 1);
                         if (on) setenv("THEW_FAIL_ON", "1", 1);
                       })
        .wait();
  };
  ASSERT_EQ(bake(root_ / "counted", 0, false).code, 0);
  const int calls = std::stoi(bytes_of(root_ / "count"));
  EXPECT_GT(calls, 100);
  for (int i = 0; i < 4 * points; ++i) {
    const int at = 1 + static_cast<int>((calls - 1L) * i / (4 * points - 1));
    SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(calls));
    const fs::path out = root_ / ("broken" + std::to_string(i));
    const auto ended = bake(out, at, i % 2 == 1);
    if (ended.code == 0) {  // a file that was only read had been closed
      expect_whole(out);
      continue;
    }
    expect_told(out, ended, out.string());
    resume(out);
    if (HasFailure()) return;
  }
}

TEST_F(Hurt, AReadOnlyFolderIsTold) {
  const fs::path folder = root_ / "closed";
  fs::create_directories(folder);
  if (geteuid() != 0) {
    fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
    const auto ended = BakeProcess(folder / "out").wait();
    EXPECT_EQ(ended.code, 4);
    fs::permissions(folder, fs::perms::owner_all);
  }
  if (!may_mount) GTEST_SKIP() << "no permission to mount a small disk";
  const Disk disk(folder, 1 << 20);
  fs::create_directory(folder / "out");
  ASSERT_TRUE(disk.change(1 << 20, MS_RDONLY));
  for (const fs::path& out : {folder / "out", folder / "deeper/out"}) {
    const auto ended = BakeProcess(out).wait();
    expect_told(out, ended, "Read-only file system");
  }
}

TEST_F(Hurt, ClosedStreamsAreNotWrittenToAFile) {
  for (const int first : {0, 1, 2}) {
    const fs::path out = root_ / ("closed" + std::to_string(first));
    const auto ended = BakeProcess(out, {"--no-render", "--json"}, [&] {
                         for (int stream = first; stream <= 2; ++stream) close(stream);
                       }).wait();
    // The bake is whole; that the report could not be printed is told.
    EXPECT_EQ(ended.code, first <= STDOUT_FILENO ? 4 : 0);
    expect_whole(out);
  }
}

TEST_F(Hurt, NothingIsWrittenThroughALink) {
  const fs::path elsewhere = root_ / "elsewhere";
  fs::create_directories(elsewhere / "folder");
  std::ofstream(elsewhere / "file") << "mine";
  std::ofstream(elsewhere / "folder/file") << "mine";
  const auto with_link = [&](const char* name, const fs::path& target) {
    const fs::path out = root_ / (std::string("link_") + name);
    fs::create_directories(out);
    fs::create_symlink(target, out / name);
    std::vector<std::string> more = {"--overwrite"};  // allows no more
    if (std::string(name) != "frames") more.push_back("--no-render");
    const auto ended = BakeProcess(out, more).wait();
    EXPECT_EQ(bytes_of(elsewhere / "file"), "mine") << name;
    EXPECT_EQ(bytes_of(elsewhere / "folder/file"), "mine") << name;
    EXPECT_EQ(std::distance(fs::directory_iterator(elsewhere / "folder"), {}), 1) << name;
    if (ended.code == 0) return expect_whole(out);
    expect_told(out, ended, "symbolic link");
    fs::remove(out / name);
    return resume(out);
  };
  with_link("bake.h5", elsewhere / "file");
  with_link("bake.h5.tmp", elsewhere / "file");
  with_link("bake.parts", elsewhere / "folder");
  with_link("report.json", elsewhere / "file");
  with_link("failure.json", elsewhere / "file");
  with_link(".thew.jsonl", elsewhere / "file");
  with_link("frames", elsewhere / "folder");
}

}  // namespace
}  // namespace thew::tests

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) thew::tests::points = std::atoi(argv[1]);
  thew::tests::may_mount =
      unshare(geteuid() == 0 ? CLONE_NEWNS : CLONE_NEWNS | CLONE_NEWUSER) == 0 &&
      mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  return RUN_ALL_TESTS();
}
