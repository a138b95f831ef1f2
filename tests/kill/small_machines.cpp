// SPDX-License-Identifier: Apache-2.0
// Commands where memory or stacks are small: they draw, or end with 75 and the limit's name.
#include <sys/resource.h>

#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

class SmallMachine : public testing::Test {
 protected:
  SmallMachine() { fs::remove_all(folder); }
  ~SmallMachine() override { fs::remove_all(folder); }

  CommandProcess::Ended bake(int limit, rlim_t bytes) const {
    CommandProcess command({"bake", THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml", "--frames",
                            "1-1", "--out", folder.string(), "--progress", "none"},
                           [=] {
                             const rlimit both{bytes, bytes};
                             setrlimit(static_cast<__rlimit_resource>(limit), &both);
                           });
    const CommandProcess::Ended ended = command.wait();
    fs::remove_all(folder);
    return ended;
  }

  const fs::path folder =
      fs::path(testing::TempDir()) / ("thew_small_machine_" + std::to_string(getpid()));
};

// Below some 230 MB the system's loader cannot map the program's libraries.
#ifndef THEW_SANITIZED  // which set aside terabytes
TEST_F(SmallMachine, LittleMemoryIsTold) {
  int drawn = 0, told = 0;
  for (rlim_t megabytes = 240; megabytes <= 1240; megabytes += 100) {
    const CommandProcess::Ended ended = bake(RLIMIT_AS, megabytes << 20);
    drawn += ended.code == 0;
    told += ended.code == 75;
    EXPECT_TRUE(ended.code == 0 || ended.code == 75) << megabytes << " MB: " << ended.code;
    EXPECT_EQ(ended.code == 0, ended.errors.empty()) << ended.errors;
    if (ended.code != 75) continue;
    EXPECT_NE(ended.errors.find("memory"), std::string::npos) << ended.errors;
  }
  EXPECT_GT(drawn, 0);
  EXPECT_GT(told, 0);
}

TEST_F(SmallMachine, SmallStacksAreEnough) {
  for (const rlim_t kilobytes : {256, 512, 1024, 2048}) {
    const CommandProcess::Ended ended = bake(RLIMIT_STACK, kilobytes << 10);
    EXPECT_EQ(ended.code, 0) << kilobytes << " KiB: " << ended.errors;
  }
}
#endif

}  // namespace
}  // namespace thew::tests
