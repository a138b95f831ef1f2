// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "rig/types.h"
#include "tools/render/contact_sheet.h"
#include "tools/render/image.h"
#include "tools/render/worker.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

Image plain(int width, int height, std::uint8_t value) {
  return {width, height, std::vector<std::uint8_t>(3ul * width * height, value)};
}

fs::path empty_folder(const char* name) {
  const fs::path folder = fs::path(::testing::TempDir()) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

TEST(Worker, DoesMoreJobsThanItQueuesInTheirOrder) {
  std::vector<int> done;
  Worker worker(3);
  for (int i = 0; i < 30; ++i) worker.add([&done, i] { done.push_back(i); });
  worker.finish();
  ASSERT_EQ(done.size(), 30u);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(done[i], i);
}

// Each job waits until so many have been queued behind it as may be, and no more ever are.
TEST(Worker, QueuesNoMoreThanItSays) {
  constexpr int kMost = 2;
  std::atomic<int> added = 0, most = 0;
  std::atomic<bool> open = false;
  Worker worker(kMost);
  std::thread opener([&] {
    while (added < 1 + kMost) std::this_thread::yield();
    open = true;
  });
  for (int i = 0; i < 20; ++i) {
    worker.add([&, i] {
      while (!open) std::this_thread::yield();
      most = std::max(most.load(), added.load() - i);
    });
    ++added;
  }
  worker.finish();
  opener.join();
  EXPECT_GE(most, kMost);
  EXPECT_LE(most, 1 + kMost);  // itself and those queued
}

TEST(Worker, RethrowsTheFirstErrorAndAddingNeverHangs) {
  const fs::path folder = empty_folder("thew_frames_error");
  Worker worker(8);
  const auto add = [&](const fs::path& file) {
    worker.add([file] { write_png(file, plain(20, 10, 0)); });
  };
  add(folder / "0.png");
  for (int i = 1; i < 30; ++i) add(folder / "none" / (std::to_string(i) + ".png"));
  const auto expect_error = [](auto&& action) {
    try {
      action();
      FAIL() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kOutput);
      EXPECT_NE(std::string(error.what()).find("none/1.png"), std::string::npos) << error.what();
    }
  };
  expect_error([&] { worker.check(); });  // of 30 jobs 8 are queued: the second has failed
  expect_error([&] { worker.finish(); });
  EXPECT_TRUE(fs::exists(folder / "0.png"));
  fs::remove_all(folder);
}

TEST(Worker, ItsEndDoesWhatIsQueued) {
  int done = 0;
  {
    Worker worker(8);
    for (int i = 0; i < 5; ++i) worker.add([&] { ++done; });
  }
  EXPECT_EQ(done, 5);
}

TEST(ContactSheet, IndicesSpreadFromFirstToLast) {
  EXPECT_EQ(spread_indices(9, 3), (std::vector<int>{0, 4, 8}));
  EXPECT_EQ(spread_indices(120, 5), (std::vector<int>{0, 30, 60, 89, 119}));
  EXPECT_EQ(spread_indices(3, 12), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(spread_indices(5, 1), (std::vector<int>{0}));
  EXPECT_TRUE(spread_indices(0, 4).empty());
}

TEST(ContactSheet, ShrinkingTakesTheMeanByArea) {
  const Image row{3, 1, {0, 0, 0, 90, 90, 90, 240, 240, 240}};
  // Two pixels of one and a half each: (0 + 90 / 2) / 1.5 and (90 / 2 + 240) / 1.5.
  EXPECT_EQ(shrink(row, 2, 1).rgb, (std::vector<std::uint8_t>{30, 30, 30, 190, 190, 190}));
  EXPECT_EQ(shrink(row, 1, 1).rgb, (std::vector<std::uint8_t>{110, 110, 110}));
  EXPECT_EQ(shrink(row, 7, 7).rgb, row.rgb) << "never enlarges";
  EXPECT_EQ(shrink(plain(97, 53, 201), 40, 11).rgb, plain(40, 11, 201).rgb);
}

TEST(ContactSheet, ThumbnailsStandRowByRowOnWhite) {
  const Image sheet =
      contact_sheet({plain(40, 20, 10), plain(40, 20, 20), plain(40, 20, 30)}, 2, 20);
  EXPECT_EQ(sheet.width, 2 * 20 + 3 * 4);
  EXPECT_EQ(sheet.height, 2 * 10 + 3 * 4);
  const auto at = [&](int x, int y) { return int(sheet.rgb[3 * (y * sheet.width + x)]); };
  EXPECT_EQ(at(4, 4), 10);
  EXPECT_EQ(at(23, 13), 10);
  EXPECT_EQ(at(28, 4), 20);
  EXPECT_EQ(at(4, 18), 30);
  EXPECT_EQ(at(28, 18), 255) << "no fourth image";
  EXPECT_EQ(at(24, 4), 255) << "the gap";
}

TEST(ContactSheet, FramesAreNumbered) {
  const Image sheet = contact_sheet({plain(60, 40, 10), plain(60, 40, 20)}, 2, 60, {7, 120});
  const auto text = [&](int x, int y, int digits) {  // rows of the digits, two pixels a dot
    std::string rows;
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 4 * digits + 1; ++i) {
        rows += sheet.rgb[3 * ((y + 2 * j) * sheet.width + x + 2 * i)] == 255 ? '.' : '#';
      }
      rows += '\n';
    }
    return rows;
  };
  EXPECT_EQ(text(4, 4, 1), ".....\n.###.\n...#.\n...#.\n..#..\n..#..\n.....\n");
  EXPECT_EQ(text(68, 4, 3),
            ".............\n..#..###.###.\n.##....#.#.#.\n..#..###.#.#.\n"
            "..#..#...#.#.\n.###.###.###.\n.............\n");
}

}  // namespace
}  // namespace thew::tests
