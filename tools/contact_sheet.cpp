// SPDX-License-Identifier: Apache-2.0
#include "tools/contact_sheet.h"

#include <algorithm>
#include <cassert>
#include <cstdint>

namespace thew {
namespace {

constexpr int kGap = 4;  // pixels of white around each thumbnail

}  // namespace

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

Image contact_sheet(const std::vector<Image>& images, int columns, int thumbnail_width) {
  assert(!images.empty() && columns > 0);
  const int count = static_cast<int>(images.size());
  columns = std::min(columns, count);
  const int width = std::min(thumbnail_width, images[0].width);
  const int height = std::max(1, images[0].height * width / images[0].width);
  const int rows = (count + columns - 1) / columns;
  Image sheet{columns * (width + kGap) + kGap, rows * (height + kGap) + kGap, {}};
  sheet.rgb.assign(3ul * sheet.width * sheet.height, 255);
  for (int k = 0; k < count; ++k) {
    const Image small = shrink(images[k], width, height);
    const int x = kGap + k % columns * (width + kGap), y = kGap + k / columns * (height + kGap);
    for (int j = 0; j < small.height; ++j) {
      std::copy_n(small.rgb.begin() + 3l * small.width * j, 3 * small.width,
                  sheet.rgb.begin() + 3l * (std::int64_t{1} * sheet.width * (y + j) + x));
    }
  }
  return sheet;
}

}  // namespace thew
