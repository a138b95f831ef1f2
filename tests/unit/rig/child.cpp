// SPDX-License-Identifier: Apache-2.0
// Failures of a reader in its child process, and how they are reported.
#include "rig/import/child.h"

#include <fcntl.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "rig/import/mesh_import.h"
#include "rig/import/packed.h"
#include "rig/import/urdf_import.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

class ChildTest : public TempFolder {
 protected:
  std::string error_of(const Child::Answer& answer) {
    return input_error([&] {
      Child child(file_, "send another", answer);
      child.ask();
    });
  }

  const std::filesystem::path file_ = write("some.file", "12 bytes long");
};

volatile unsigned sink = 0;  // which may overflow
[[maybe_unused]] int overflow(int depth) {
  volatile char frame[1000] = {};
  frame[depth % 1000] = 1;
  return depth < 0 ? 0 : overflow(depth + 1) + frame[1];
}

TEST_F(ChildTest, AnswersOneRequestAfterAnother) {
  int asked = 0;
  Child child(file_, "", [&](std::string_view request) {
    return std::string(request) + std::to_string(++asked);
  });
  EXPECT_EQ(child.ask("a"), "a1");
  EXPECT_EQ(child.ask(), "2");
  const std::string large(10 << 20, 'x');
  EXPECT_TRUE(child.ask(large) == large + "3");
  EXPECT_EQ(asked, 0);  // it has a memory of its own
}

TEST_F(ChildTest, AnErrorArrivesAsItIs) {
  Child child(file_, "", [](std::string_view request) -> std::string {
    if (request == "again") return "fine";
    throw Error(ErrorCode::kSolver, "of this kind");
  });
  try {
    child.ask();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kSolver);
    EXPECT_STREQ(error.what(), "of this kind");
  }
  EXPECT_EQ(child.ask("again"), "fine");
}

TEST_F(ChildTest, OtherExceptionsGetThePlaceAndTheMove) {
  EXPECT_EQ(error_of([](std::string_view) -> std::string { throw std::length_error("too long"); }),
            file_.string() + ": too long; send another");
  EXPECT_EQ(error_of([](std::string_view) -> std::string { throw 7; }),
            file_.string() + ": its reader crashed (Aborted); send another");
}

TEST_F(ChildTest, ACrashIsTold) {
  EXPECT_HAS(error_of([](std::string_view) -> std::string { std::abort(); }), "crashed (Aborted)");
  EXPECT_HAS(error_of([](std::string_view) -> std::string {
               raise(SIGSEGV);
               return "";
             }),
             "crashed (Segmentation fault)");
  EXPECT_HAS(error_of([](std::string_view) -> std::string { _exit(0); }), "ended too soon");
#ifndef THEW_SANITIZED
  EXPECT_HAS(error_of([](std::string_view) -> std::string { return {char(overflow(0))}; }),
             "crashed (Segmentation fault)");
#endif
}

TEST_F(ChildTest, AHangIsEnded) {
  const std::string message = error_of([](std::string_view) -> std::string {
    for (;;) sink = sink + 1;
  });
  EXPECT_EQ(message, file_.string() + ": reading it was ended after 2 s; send another");
}

TEST_F(ChildTest, MemoryHasItsLimit) {
#ifdef THEW_SANITIZED
  GTEST_SKIP() << "a sanitizer ends the process itself";
#endif
  std::vector<char> mine(std::size_t{600} << 20, 1);  // what the parent has does not count
  EXPECT_HAS(error_of([](std::string_view) {
               // Not written to: where pages are slow, the limit of time would come first.
               std::vector<std::unique_ptr<char[]>> all;
               for (;;) all.emplace_back(new char[1 << 20]);
               return std::string();
             }),
             "takes more than 1024 MiB of memory");
  EXPECT_EQ(error_of([](std::string_view) {
              const std::unique_ptr<char[]> most(new char[900u << 20]);
              most[0] = 'x';
              return std::string(1, most[0]);
            }),
            "");
}

TEST_F(ChildTest, IsGoneWithItsParent) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // what its parent leaves behind becomes ours
  const pid_t parent = fork();
  if (parent == 0) {
    Child child(file_, "", [](std::string_view) -> std::string {
      for (;;) pause();
    });
    std::thread([] { raise(SIGKILL); }).join();
  }
  waitpid(parent, nullptr, 0);
  int status = 0;
  EXPECT_GT(waitpid(-1, &status, 0), 0);
  const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  // 1: before it could ask for that; 0: it saw the socket closed before the signal came.
  const bool alone = WIFEXITED(status) && WEXITSTATUS(status) <= 1;
  EXPECT_TRUE(killed || alone) << status;
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

#ifndef THEW_SANITIZED  // there is no filter then
TEST_F(ChildTest, NoNetworkAndNoOtherProcess) {
  const std::pair<const char*, std::function<void()>> attempts[] = {
      {"tcp", [] { socket(AF_INET, SOCK_STREAM, 0); }},
      {"udp", [] { socket(AF_INET6, SOCK_DGRAM, 0); }},
      {"unix", [] { socket(AF_UNIX, SOCK_STREAM, 0); }},
      {"netlink", [] { socket(AF_NETLINK, SOCK_RAW, 0); }},
      {"fork", [] { fork(); }},
      {"thread", [] { std::thread([] {}).join(); }},
      {"execve", [] { execl("/bin/true", "true", nullptr); }},
      {"ptrace", [] { ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); }},
      {"kill", [] { kill(getppid(), SIGTERM); }},
      {"memory", [] { process_vm_readv(getppid(), nullptr, 0, nullptr, 0, 0); }},
  };
  for (const auto& [name, attempt] : attempts) {
    const auto& trying = attempt;
    EXPECT_EQ(error_of([&](std::string_view) {
                trying();
                return std::string("still there");
              }),
              file_.string() +
                  ": its reader was ended: it asked for a network or another process; send another")
        << name;
  }
}

TEST_F(ChildTest, NoFilesButItsOwn) {
  write("other.file", "another");
  const int before = open(file_.c_str(), O_RDWR);  // of the parent
  ASSERT_GE(before, 0);
  const std::string there = file_.string(), fresh = there + ".new";
  Child child(file_, "", [&](std::string_view) {
    std::string got;
    const auto refused = [&](const char* what, long result) {
      if (result != -1 || errno != EPERM) got += std::string(what) + " ";
    };
    refused("passwd", open("/etc/passwd", O_RDONLY));
    refused("own", open(there.c_str(), O_RDONLY));
    refused("create", open(fresh.c_str(), O_WRONLY | O_CREAT, 0600));
    refused("unlink", unlink(there.c_str()));
    refused("rename", rename(there.c_str(), fresh.c_str()));
    refused("mkdir", mkdir(fresh.c_str(), 0700));
    refused("link", symlink(there.c_str(), fresh.c_str()));
    refused("chmod", chmod(there.c_str(), 0777));
    refused("list", open("/", O_RDONLY | O_DIRECTORY));
    struct stat status {};
    refused("stat", stat(there.c_str(), &status));
    rlimit none{RLIM_INFINITY, RLIM_INFINITY};
    refused("memory", setrlimit(RLIMIT_AS, &none));
    if (::write(before, "x", 1) != -1 || errno != EBADF) got += "the parent's ";
    return got;
  });
  EXPECT_EQ(child.ask(), "");
  EXPECT_EQ(child.ask(), "");  // and goes on
  close(before);
  EXPECT_EQ(std::filesystem::file_size(file_), 13u);
  EXPECT_FALSE(std::filesystem::exists(fresh));
}
#endif

TEST_F(ChildTest, ItsOwnFilesAreThoseOfItsFolder) {
  std::filesystem::create_directory(folder / "below");
  write("below/part.bin", "below");
  const auto outside = std::filesystem::path(folder).concat(".outside");
  std::ofstream(outside) << "secret";
  std::filesystem::create_symlink(outside, folder / "way_out");
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  Child child(file_, "", [](std::string_view name) { return read_in_child(name, 1000); });
  EXPECT_EQ(child.ask("some.file"), "12 bytes long");
  EXPECT_EQ(child.ask(file_.string()), "12 bytes long");
  EXPECT_EQ(child.ask("below/part.bin"), "below");
  for (const std::string& name :
       {std::string("/etc/passwd"), outside.string(), "../" + outside.filename().string(),
        std::string("way_out"), std::string("pipe"), std::string("below"), std::string("."),
        std::string(), std::string("not_there")}) {
    EXPECT_HAS(input_error([&] { child.ask(name); }), "cannot be read") << name;
  }
  std::filesystem::remove(outside);
  EXPECT_HAS(error_of([](std::string_view) {
               for (;;) open_in_child("not_there");
               return std::string();
             }),
             "needs more than 1000 files");
}

// As in a container that forbids filters: only the resource limits apply, and files are read.
TEST_F(ChildTest, WhereTheKernelTakesNoFilterItReads) {
  const pid_t process = fork();
  if (process == 0) {
    const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(seccomp), 0);
    seccomp_load(filter);
    std::string read;
    {
      Child child(file_, "", [](std::string_view) {
        const bool open_world = ::open("/dev/null", O_RDONLY) >= 0;
        return read_in_child(file_of_child(), 1000) + (open_world ? "" : " confined");
      });
      read = child.ask();
    }
    _exit(read == "12 bytes long" ? 0 : 1);
  }
  int status = 0;
  waitpid(process, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST_F(ChildTest, LeavesNoProcessBehind) {
  {
    Child child(file_, "", [](std::string_view) { return std::string(); });
    child.ask();
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

// Every prefix of a file; assimp 5.2 never ends on some of them and crashes on others.
TEST_F(ChildTest, APlyFileCutShortIsEnded) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto whole = write("whole.ply", header + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(import_mesh(whole).mesh.triangles.size(), 1u);
  EXPECT_HAS(input_error([&] { import_mesh(write("cut.ply", header.substr(0, 60))); }),
             "cut.ply: ");
}

TEST(Packed, ComesBackAndRefusesEveryCut) {
  struct {
    std::string text = "text";
    std::vector<double> numbers = {1.5, -0.0};
    std::vector<std::string> texts = {"", "b"};
    int number = 7;
  } in, out;
  const auto walk = [](auto& archive, auto& values) {
    archive.list(values.text);
    archive.list(values.numbers);
    archive.each(values.texts, [](auto& inner, std::string& text) { inner.list(text); });
    archive.number(values.number);
  };
  out = {{}, {}, {}, 0};
  Packer packer;
  walk(packer, in);
  Unpacker whole{packer.bytes};
  walk(whole, out);
  EXPECT_TRUE(whole.finished());
  EXPECT_EQ(out.text, in.text);
  EXPECT_EQ(out.numbers, in.numbers);
  EXPECT_EQ(out.texts, in.texts);
  EXPECT_EQ(out.number, 7);
  for (size_t cut = 0; cut < packer.bytes.size(); ++cut) {
    Unpacker part{std::string_view(packer.bytes).substr(0, cut)};
    walk(part, out);
    EXPECT_FALSE(part.finished()) << cut;
  }
  std::string claims(8, '\xff');  // 2^64 - 1 numbers
  Unpacker huge{claims};
  huge.list(out.numbers);
  EXPECT_FALSE(huge.good);
}

}  // namespace
}  // namespace thew::tests
