// SPDX-License-Identifier: Apache-2.0
// What a message is taken apart into for programs.
#include "tools/base/printing.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

using Words = std::vector<std::string>;

void expect_parts(const std::string& message, const ErrorParts& expected, const Words& words = {}) {
  const ErrorParts found = split_error(message, words);
  EXPECT_EQ(found.file, expected.file) << message;
  EXPECT_EQ(found.line, expected.line) << message;
  EXPECT_EQ(found.message, expected.message) << message;
  EXPECT_EQ(found.next, expected.next) << message;
}

TEST(SplitError, FileLineMessageAndNextMove) {
  expect_parts(
      "arm.toml:12: unknown key \"bely\" in [muscle.side]; did you mean \"belly\"?",
      {"arm.toml", 12, "unknown key \"bely\" in [muscle.side]", "did you mean \"belly\"?"});
  expect_parts(
      "out/x: cannot create the folder: Not a directory; check the folder and its "
      "permissions, then run again with --resume",
      {"out/x", 0, "cannot create the folder: Not a directory",
       "check the folder and its permissions, then run again with --resume"});
  expect_parts("a.glb: its reader crashed (Segmentation fault); export it again",
               {"a.glb", 0, "its reader crashed (Segmentation fault)", "export it again"});
  expect_parts("a.obj: 3 edges are open; 2 faces are turned; mend it",
               {"a.obj", 0, "3 edges are open; 2 faces are turned", "mend it"});
}

TEST(SplitError, NoFile) {
  expect_parts("interrupted; run again", {"", 0, "interrupted", "run again"});
  expect_parts(
      "--frames 1-x: \"1-x\" is not a frame or a range; write for instance 1-120",
      {"", 0, "--frames 1-x: \"1-x\" is not a frame or a range", "write for instance 1-120"});
  expect_parts("--set rig.file=a/b.urdf: is not there; correct it",
               {"", 0, "--set rig.file=a/b.urdf: is not there", "correct it"});
  expect_parts("muscle \"a/b\": frame 7: node 3 is nan",
               {"", 0, "muscle \"a/b\": frame 7: node 3 is nan", ""});
  expect_parts("standard output: cannot be written: Broken pipe; read it all",
               {"", 0, "standard output: cannot be written: Broken pipe", "read it all"});
  expect_parts("", {});
  expect_parts(": ", {"", 0, ": ", ""});
}

TEST(SplitError, NextMoveOutsideOfQuotes) {
  expect_parts("a.toml:3: body \"a; b\" is not in the rig",
               {"a.toml", 3, "body \"a; b\" is not in the rig", ""});
  expect_parts("a.toml:3: body \"a; b\" is not in the rig; did you mean \"a; c\"?",
               {"a.toml", 3, "body \"a; b\" is not in the rig", "did you mean \"a; c\"?"});
}

TEST(SplitError, OddNamesOfTheCommandLine) {
  const std::string odd = "my: scene; 2.toml";
  expect_parts(odd + ":7: bad; mend it", {odd, 7, "bad", "mend it"}, {"bake", odd});
  expect_parts(odd + ": there is no such file; check the path",
               {odd, 0, "there is no such file", "check the path"}, {"bake", odd});
  expect_parts("out: a/frames/x y.png: cannot open: Permission denied; run again",
               {"out: a/frames/x y.png", 0, "cannot open: Permission denied", "run again"},
               {"--out", "out: a"});
  expect_parts("take:7: not a mesh; mend it", {"take:7", 0, "not a mesh", "mend it"}, {"take:7"});
  expect_parts("C:\\scenes\\arm.toml:12: bad; mend it",
               {"C:\\scenes\\arm.toml", 12, "bad", "mend it"});
  expect_parts("C:\\my scenes\\arm.toml:12: bad; mend it",
               {"C:\\my scenes\\arm.toml", 12, "bad", "mend it"}, {"C:\\my scenes\\arm.toml"});
  expect_parts("a.toml:99999999999999: bad", {"a.toml:99999999999999", 0, "bad", ""});
}

class SplitErrorOnDisk : public TempFolder {};

TEST_F(SplitErrorOnDisk, AFileThatIsThere) {
  const std::string odd = write("a mesh: of two.obj", "").string();
  expect_parts(odd + ":2: three numbers are wanted; correct it",
               {odd, 2, "three numbers are wanted", "correct it"});
}

TEST(ErrorAsJson, NullWhereThereIsNone) {
  EXPECT_EQ(error_as_json(ErrorCode::kUsage, {"a.toml", 12, "bad", "mend it"}).dump(),
            "{\"error\":{\"code\":2,\"file\":\"a.toml\",\"line\":12,\"message\":\"bad\","
            "\"next\":\"mend it\"}}");
  EXPECT_EQ(error_as_json(ErrorCode::kRetry, {"", 0, "interrupted", ""}).dump(),
            "{\"error\":{\"code\":75,\"file\":null,\"line\":null,\"message\":\"interrupted\","
            "\"next\":null}}");
}

}  // namespace
}  // namespace thew::tests
