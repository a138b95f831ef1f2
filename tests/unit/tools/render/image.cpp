// SPDX-License-Identifier: Apache-2.0
#include "tools/render/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "rig/types.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class ImageFile : public ::testing::Test {
 protected:
  ImageFile() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) /
              ("thew_image_" + std::to_string(getpid()) + "_" + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ImageFile() override { fs::remove_all(folder_); }

  std::optional<ErrorCode> code_of(auto&& action) {
    try {
      action();
    } catch (const Error& error) {
      message_ = error.what();
      return error.code();
    }
    return std::nullopt;
  }

  fs::path folder_;
  std::string message_;
};

// Every pixel differs from its neighbours, so that no filter is trivial.
Image pattern(int width, int height) {
  Image image{width, height, {}};
  std::uint32_t state = 1;
  for (int i = 0; i < 3 * width * height; ++i) {
    state = state * 1664525u + 1013904223u;
    image.rgb.push_back(static_cast<std::uint8_t>(state >> 24));
  }
  return image;
}

TEST_F(ImageFile, RoundTripIsExactAtEveryLevel) {
  const Image image = pattern(37, 23);
  for (const int level : {0, 1, 9}) {
    write_png(folder_ / "a.png", image, level);
    const Image back = read_png(folder_ / "a.png");
    EXPECT_EQ(back.width, 37);
    EXPECT_EQ(back.height, 23);
    EXPECT_EQ(back.rgb, image.rgb) << "level " << level;
  }
}

TEST_F(ImageFile, TheSameImageGivesTheSameFile) {
  const auto bytes = [](const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  write_png(folder_ / "a.png", pattern(64, 64));
  write_png(folder_ / "b.png", pattern(64, 64));
  EXPECT_EQ(bytes(folder_ / "a.png"), bytes(folder_ / "b.png"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 3)  // and the list of what is ours
      << "something was left beside";
}

TEST_F(ImageFile, WritingIntoAFolderThatIsNotThereIsAnOutputError) {
  const fs::path file = folder_ / "none" / "a.png";
  EXPECT_EQ(code_of([&] { write_png(file, pattern(4, 4)); }), ErrorCode::kOutput);
  EXPECT_NE(message_.find(file.string()), std::string::npos) << message_;
}

TEST_F(ImageFile, AFailedWriteLeavesTheOldImage) {
  const fs::path file = folder_ / "a.png";
  write_png(file, pattern(5, 5));
  fs::remove(folder_ / ".thew.jsonl");
  fs::create_directory(folder_ / ".thew.jsonl");  // nothing can be listed
  EXPECT_EQ(code_of([&] { write_png(file, pattern(9, 9)); }), ErrorCode::kOutput);
  EXPECT_EQ(read_png(file).width, 5);
}

TEST_F(ImageFile, WhatIsNoWholePngIsAnInputError) {
  const fs::path file = folder_ / "a.png";
  EXPECT_EQ(code_of([&] { read_png(file); }), ErrorCode::kInput) << "missing";
  EXPECT_EQ(code_of([&] { read_png(folder_); }), ErrorCode::kInput) << "a folder";
  std::ofstream(file) << "not a picture at all";
  EXPECT_EQ(code_of([&] { read_png(file); }), ErrorCode::kInput) << "text";
  fs::remove(file);
  write_png(file, pattern(64, 64));
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_EQ(code_of([&] { read_png(file); }), ErrorCode::kInput) << "half a file";
}

TEST_F(ImageFile, AHeaderThatClaimsTooMuchIsRefusedBeforeItIsAllocated) {
  const fs::path file = folder_ / "a.png";
  // Signature, then IHDR of 999,999 x 999,999 RGB with its right CRC.
  const unsigned char header[] = {0x89, 'P',  'N',  'G',  13,  10,  26,   10,   0,    0,
                                  0,    13,   'I',  'H',  'D', 'R', 0x00, 0x0f, 0x42, 0x3f,
                                  0x00, 0x0f, 0x42, 0x3f, 8,   2,   0,    0,    0};
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t i = 12; i < sizeof header; ++i) {
    crc ^= header[i];
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  crc = ~crc;
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(header), sizeof header);
  for (const int shift : {24, 16, 8, 0}) out.put(static_cast<char>(crc >> shift));
  const unsigned char data[] = {0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e};
  out.write(reinterpret_cast<const char*>(data), sizeof data);
  out.close();
  EXPECT_EQ(code_of([&] { read_png(file); }), ErrorCode::kInput);
  EXPECT_NE(message_.find("16384"), std::string::npos) << message_;
}

}  // namespace
}  // namespace thew::tests
