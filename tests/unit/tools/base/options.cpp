// SPDX-License-Identifier: Apache-2.0
#include "tools/base/options.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "rig/types.h"
#include "tools/base/progress.h"

namespace thew::tests {
namespace {

using Frames = std::vector<int>;

TEST(Frames, RangesStepsAndLists) {
  EXPECT_EQ(parse_frames("7"), Frames({7}));
  EXPECT_EQ(parse_frames("1-4"), Frames({1, 2, 3, 4}));
  EXPECT_EQ(parse_frames("1-7x3"), Frames({1, 4, 7}));
  EXPECT_EQ(parse_frames("1-8:3"), Frames({1, 4, 7}));
  EXPECT_EQ(parse_frames("9,1-3, 2-4 ,9"), Frames({1, 2, 3, 4, 9}));
  EXPECT_EQ(parse_frames("5-5"), Frames({5}));
  EXPECT_EQ(parse_frames("1-120x2").size(), 60u);
}

TEST(Frames, Negatives) {
  EXPECT_EQ(parse_frames("-3"), Frames({-3}));
  EXPECT_EQ(parse_frames("-5--3"), Frames({-5, -4, -3}));
  EXPECT_EQ(parse_frames("-2-2x2"), Frames({-2, 0, 2}));
}

void expect_refused(const std::string& text, const std::string& word) {
  try {
    parse_frames(text, -10, 120);
    ADD_FAILURE() << text << " was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(Frames, RefusesWithAReason) {
  for (const char* text : {"", ",", "1,", "a", "1-", "1-2-3", "1-2x", "1x2", "1.5", "1-3y2", "+1",
                           "99999999999", "1 2"}) {
    expect_refused(text, "not a frame");
  }
  expect_refused("9-1", "write 1-9");
  expect_refused("1-9x0", "step");
  expect_refused("1-9x-2", "step");
  expect_refused("-2147483648-2147483647", "million");
  expect_refused("1-121", "frame 121 is outside the scene's frames -10-120");
  expect_refused("-11-3", "frame -11 is outside");
  EXPECT_EQ(parse_frames("-10,120", -10, 120), Frames({-10, 120}));
}

TEST(ProgressWords, AutoFollowsTheTerminal) {
  EXPECT_EQ(parse_progress("auto", true), ProgressStyle::kBar);
  EXPECT_EQ(parse_progress("auto", false), ProgressStyle::kPlain);
  EXPECT_EQ(parse_progress("json", true), ProgressStyle::kJson);
  EXPECT_EQ(parse_progress("none", true), ProgressStyle::kNone);
  try {
    parse_progress("jsn", true);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("did you mean json?"), std::string::npos);
  }
}

/// What 120 frames print, of which the first `found` were done before.
std::string printed(ProgressStyle style, int found = 0) {
  std::FILE* out = std::tmpfile();
  {
    Progress progress(style, "baking", 120, out);
    for (int done = found + 1; done <= 120; ++done) progress.step(done, done + 100);
  }
  std::string text(static_cast<std::size_t>(std::ftell(out)), '\0');
  std::rewind(out);
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), out), text.size());
  std::fclose(out);
  return text;
}

TEST(ProgressLines, ALogGetsFewLinesAndTheLastFrame) {
  const std::string text = printed(ProgressStyle::kPlain);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 20);
  EXPECT_NE(text.find("baking: frame 220, 120 of 120, 0 s left\n"), std::string::npos) << text;
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(ProgressLines, EachLineOfJsonStandsAlone) {
  std::istringstream lines(printed(ProgressStyle::kJson, 20));
  int expected = 21;
  for (std::string line; std::getline(lines, line); ++expected) {
    const auto read = nlohmann::json::parse(line);
    EXPECT_EQ(read.at("done"), expected);
    EXPECT_EQ(read.at("frame"), expected + 100);
    EXPECT_EQ(read.at("total"), 120);
    EXPECT_GE(read.at("seconds_left").get<double>(), 0.0);
  }
  EXPECT_EQ(expected, 121);
}

TEST(ProgressLines, ABarStaysOnItsLine) {
  const std::string text = printed(ProgressStyle::kBar);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 120);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_EQ(text.back(), '\n');
}

TEST(ProgressLines, NoneIsSilent) { EXPECT_EQ(printed(ProgressStyle::kNone), ""); }

TEST(ProgressLines, DurationsAreReadable) {
  EXPECT_EQ(duration(0.4), "0 s");
  EXPECT_EQ(duration(59.6), "1 min 00 s");
  EXPECT_EQ(duration(185), "3 min 05 s");
  EXPECT_EQ(duration(3725), "1 h 02 min");
}

TEST(CommandText, IsWhatAShellReadsAsTheSameWords) {
  const char* words[] = {"thew", "bake", "a b.toml", "--set", "x=[1, 2]", "it's", "", "--out=o/é"};
  EXPECT_EQ(command_text(8, words),
            "thew bake 'a b.toml' --set 'x=[1, 2]' 'it'\\''s' '' --out=o/é");
}

}  // namespace
}  // namespace thew::tests
