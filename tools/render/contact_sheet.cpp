// SPDX-License-Identifier: Apache-2.0
#include "tools/render/contact_sheet.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <string>

namespace thew::tools {
namespace {

constexpr int kGap = 4;  // pixels of white around each thumbnail

// Each character 3 by 5, a row an octal digit.
constexpr const char kCharacters[] = "0123456789-.e+";
constexpr int kDots[] = {075557, 026227, 071747, 071717, 055711, 074717, 074757,
                         071122, 075757, 075717, 000700, 000002, 075747, 002720};
constexpr int kNumberDot = 2;  // pixels, of each dot of a number

}  // namespace

void write_text(const std::string& text, int x, int y, int dot_size, Image& image) {
  const auto dot = [&](int column, int row, std::uint8_t value) {
    for (int j = 0; j < dot_size; ++j) {
      for (int i = 0; i < dot_size; ++i) {
        const int px = x + column * dot_size + i, py = y + row * dot_size + j;
        if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
        std::fill_n(image.rgb.begin() + 3l * (std::int64_t{1} * py * image.width + px), 3, value);
      }
    }
  };
  int column = 0;
  for (const char c : text) {
    const char* at = std::strchr(kCharacters, c);
    const int dots = at && *at ? kDots[at - kCharacters] : 0;
    for (int k = 0; k < 5 * 7; ++k) dot(column + k % 5, k / 5, 255);  // and a white rim
    for (int k = 0; k < 15; ++k) {
      if (dots >> (14 - k) & 1) dot(column + 1 + k % 3, 1 + k / 3, 40);
    }
    column += 4;
  }
}

std::vector<int> spread_indices(int count, int wanted) {
  std::vector<int> indices;
  const int number = std::min(count, wanted);
  for (int i = 0; i < number; ++i) {
    const std::int64_t steps = std::max(number - 1, 1);
    indices.push_back(static_cast<int>((std::int64_t{i} * (count - 1) + steps / 2) / steps));
  }
  return indices;
}

Image shrink(const Image& image, int width, int height) {
  width = std::min(width, image.width);
  height = std::min(height, image.height);
  Image small{width, height, std::vector<std::uint8_t>(3ul * width * height)};
  // Integers throughout: pixel x covers [x W, (x + 1) W) where input pixel i covers [i w, (i + 1)
  // w).
  const std::int64_t area = std::int64_t{image.width} * image.height;
  const auto overlap = [](std::int64_t out, std::int64_t out_size, std::int64_t in,
                          std::int64_t in_size) {
    return std::min((out + 1) * in_size, (in + 1) * out_size) -
           std::max(out * in_size, in * out_size);
  };
  for (int y = 0; y < height; ++y) {
    const int top = static_cast<int>(std::int64_t{y} * image.height / height);
    for (int x = 0; x < width; ++x) {
      const int left = static_cast<int>(std::int64_t{x} * image.width / width);
      std::int64_t sum[3] = {};
      for (int j = top; j < image.height && overlap(y, height, j, image.height) > 0; ++j) {
        for (int i = left; i < image.width && overlap(x, width, i, image.width) > 0; ++i) {
          const std::int64_t share =
              overlap(y, height, j, image.height) * overlap(x, width, i, image.width);
          for (int c = 0; c < 3; ++c) {
            sum[c] += share * image.rgb[3ul * (std::size_t{1} * j * image.width + i) + c];
          }
        }
      }
      for (int c = 0; c < 3; ++c) {
        small.rgb[3ul * (std::size_t{1} * y * width + x) + c] =
            static_cast<std::uint8_t>((sum[c] + area / 2) / area);
      }
    }
  }
  return small;
}

Image contact_sheet(const std::vector<Image>& images, int columns, int thumbnail_width,
                    const std::vector<int>& numbers) {
  assert(numbers.empty() || numbers.size() == images.size());
  assert(!images.empty() && columns > 0);
  const int count = static_cast<int>(images.size());
  columns = std::min(columns, count);
  const int width = std::min(thumbnail_width, images[0].width);
  const int height = std::max(1, images[0].height * width / images[0].width);
  const int rows = (count + columns - 1) / columns;
  Image sheet{
      columns * (width + kGap) + kGap, rows * (height + kGap) + kGap, {}, images[0].renderer};
  sheet.rgb.assign(3ul * sheet.width * sheet.height, 255);
  for (int k = 0; k < count; ++k) {
    const Image small = shrink(images[k], width, height);
    const int x = kGap + k % columns * (width + kGap), y = kGap + k / columns * (height + kGap);
    for (int j = 0; j < small.height; ++j) {
      std::copy_n(small.rgb.begin() + 3l * small.width * j, 3 * small.width,
                  sheet.rgb.begin() + 3l * (std::int64_t{1} * sheet.width * (y + j) + x));
    }
    if (!numbers.empty()) write_text(std::to_string(numbers[k]), x, y, kNumberDot, sheet);
  }
  return sheet;
}

}  // namespace thew::tools
