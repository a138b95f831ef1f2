// SPDX-License-Identifier: Apache-2.0
//
// The measures of two pictures against values that can be derived, and against the formulas of
// the papers evaluated directly (two-dimensional kernels, numpy) on one pattern.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/rig/temp.h"
#include "tools/compare/flip.h"
#include "tools/compare/image_metrics.h"

namespace thew::tests {
namespace {

constexpr int kWidth = 48, kHeight = 32;

template <typename Colour>
Image paint(Colour colour, int width = kWidth, int height = kHeight) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int c : colour(x, y)) image.rgb.push_back(static_cast<std::uint8_t>(c));
    }
  }
  return image;
}

using Colour = std::array<int, 3>;

Image plain(int r, int g, int b) {
  return paint([&](int, int) { return Colour{r, g, b}; });
}

Image pattern() {
  return paint([](int x, int y) { return Colour{x * 5 + y * 3, x * y, x * 7 + y * y}; });
}
Image changed_pattern() {
  return paint([](int x, int y) { return Colour{x * 5 + y * 3, (x + 1) * y, x * 7 + y * y + 20}; });
}

double mean_flip(const Image& a, const Image& b) {
  double sum = 0.0;
  for (const double value : flip(a, b).values) sum += value;
  return sum / (1.0 * a.width * a.height);
}

TEST(Flip, IsZeroForTheSameAndOneForGreenAgainstBlue) {
  EXPECT_EQ(mean_flip(pattern(), pattern()), 0.0);
  // The farthest colours of all; plain pictures have no features.
  EXPECT_NEAR(mean_flip(plain(0, 255, 0), plain(0, 0, 255)), 1.0, 1e-12);
}

TEST(Flip, BlackAgainstWhite) {
  // HyAB is 100 in L*. c_max from Hunt-adjusted green and blue is 41.28^(1/0.7) to the power 0.7;
  // beyond the knee at 0.4 c_max: 0.95 + 0.05 (100^0.7 - 0.4 c_max) / (0.6 c_max).
  EXPECT_NEAR(mean_flip(plain(0, 0, 0), plain(255, 255, 255)), 0.96738, 1e-5);
}

TEST(Flip, IsSymmetric) {
  EXPECT_DOUBLE_EQ(mean_flip(pattern(), changed_pattern()),
                   mean_flip(changed_pattern(), pattern()));
}

TEST(Flip, AsThePaperSays) {
  const Plane error = flip(pattern(), changed_pattern());
  EXPECT_NEAR(mean_flip(pattern(), changed_pattern()), 0.31614267431, 1e-8);
  EXPECT_NEAR(error.values[10 * kWidth + 20], 0.38892271191, 1e-8);
  const auto edge = [](int at) {
    return paint([&](int x, int) { return x < at ? Colour{0, 0, 0} : Colour{255, 255, 255}; });
  };
  const Plane moved = flip(edge(24), edge(25));
  EXPECT_NEAR(mean_flip(edge(24), edge(25)), 0.06896337025, 1e-8);
  EXPECT_NEAR(moved.values[16 * kWidth + 24], 0.53817374491, 1e-8);
}

TEST(PixelMeasures, CountsLargestPlaceAndRmse) {
  const Image a = plain(100, 100, 100);
  Image b = a;
  b.rgb[3 * (7 * kWidth + 5) + 1] = 110;
  b.rgb[3 * (9 * kWidth + 6) + 2] = 98;
  const PixelMeasures m = measure_pixels(a, b, nullptr, 0);
  EXPECT_DOUBLE_EQ(m.share, 2.0 / (kWidth * kHeight));
  EXPECT_EQ(m.largest, 10);
  EXPECT_EQ(m.x, 5);
  EXPECT_EQ(m.y, 7);
  EXPECT_DOUBLE_EQ(m.rmse, std::sqrt((100.0 + 4.0) / (3.0 * kWidth * kHeight)));
  EXPECT_DOUBLE_EQ(measure_pixels(a, b, nullptr, 2).share, 1.0 / (kWidth * kHeight));
}

TEST(PixelMeasures, SsimAsItsPaperSays) {
  const PixelMeasures m = measure_pixels(pattern(), changed_pattern(), nullptr, 0);
  EXPECT_NEAR(m.ssim, 0.71103974338, 1e-8);
  EXPECT_NEAR(m.rmse, 49.57205754141, 1e-8);
  // Plain ones differ in lightness only: (2 m n + C1) / (m^2 + n^2 + C1).
  EXPECT_NEAR(measure_pixels(plain(80, 80, 80), plain(90, 90, 90), nullptr, 0).ssim,
              (2.0 * 80 * 90 + 6.5025) / (80.0 * 80 + 90 * 90 + 6.5025), 1e-9);
}

// Only about what changed is measured, which comes to the same, at a border as well.
TEST(PixelMeasures, FlipIsThatOfTheWholePicture) {
  const auto hash = [](int x, int y) { return (x * 7919 + y * 104729) % 251; };
  const Image expected = paint(
      [&](int x, int y) {
        return Colour{hash(x, y), (x * y) % 256, 2 * x};
      },
      120, 100);
  for (const auto& [x, y, size] : {std::array{0, 0, 1},
                                   {119, 99, 1},
                                   {60, 50, 7},
                                   {0, 70, 20},
                                   {100, 0, 20},
                                   {30, 99, 1},
                                   {0, 0, 120}}) {
    Image actual = expected;
    for (int j = y; j < std::min(y + size, actual.height); ++j) {
      for (int i = x; i < std::min(x + size, actual.width); ++i) {
        actual.rgb[3 * (actual.width * j + i) + 1] ^= 0x5a;
      }
    }
    const PixelMeasures measures = measure_pixels(expected, actual, nullptr, 0);
    EXPECT_GT(measures.flip, 0.0);
    EXPECT_EQ(measures.flip, mean_flip(expected, actual)) << x << ", " << y;
  }
}

TEST(PixelMeasures, NothingBehindTheMaskCounts) {
  const Image a = plain(100, 100, 100);
  Image b = a;
  for (int x = 0; x < 10; ++x) b.rgb[3 * x] = 255;
  const Image mask = paint([](int x, int y) {
    return x < 10 && y == 0 ? Colour{} : Colour{255, 255, 255};
  });
  const PixelMeasures m = measure_pixels(a, b, &mask, 0);
  EXPECT_EQ(m.largest, 0);
  EXPECT_EQ(m.flip, 0.0);
  EXPECT_EQ(m.ssim, 1.0);
  EXPECT_GT(measure_pixels(a, b, nullptr, 0).largest, 0);

  const Image small = paint([](int, int) { return Colour{}; }, 3, 3), dark = plain(0, 0, 0);
  EXPECT_HAS(input_error([&] { measure_pixels(a, b, &small, 0); }), "mask is 3 x 3");
  EXPECT_HAS(input_error([&] { measure_pixels(a, b, &dark, 0); }), "dark everywhere");
}

TEST(PixelMeasures, AShiftOfThePictureIsNamed) {
  const auto blob = [](double dx, double dy) {
    return paint([&](int x, int y) {
      const double r = std::hypot(x - 24 - dx, y - 16 - dy);
      const int c = static_cast<int>(200.0 * std::exp(-r * r / 50.0) + 0.5);
      return Colour{c, c, c};
    });
  };
  const PixelMeasures m = measure_pixels(blob(0, 0), blob(0.5, -0.25), nullptr, 0);
  EXPECT_NEAR(m.shift_x, 0.5, 0.02);
  EXPECT_NEAR(m.shift_y, -0.25, 0.02);
  // One that grows has not moved.
  const Image brighter = paint([&](int x, int y) {
    const int c = blob(0, 0).rgb[3 * (y * kWidth + x)];
    return Colour{c * 11 / 10, c * 11 / 10, c * 11 / 10};
  });
  const PixelMeasures grown = measure_pixels(blob(0, 0), brighter, nullptr, 0);
  EXPECT_EQ(grown.shift_x, 0.0);
  EXPECT_EQ(grown.shift_y, 0.0);
}

TEST(PixelLimits, NoiseOfAnotherProcessorPassesAndNotMuchMore) {
  // 3 levels of 255 on 0.1 % of the pixels, in any direction and channel.
  const int width = 320, height = 180, noisy = width * height / 1000;
  const Image a = paint(
      [](int x, int y) {
        return Colour{x % 200 + 20, y, (x + y) % 250};
      },
      width, height);
  std::mt19937 random(1);
  const auto with_noise = [&](int pixels, int levels) {
    Image b = a;
    for (int n = 0; n < pixels; ++n) {
      const std::size_t i = 3ul * (1000ul * n + random() % 1000) + random() % 3;
      b.rgb[i] = static_cast<std::uint8_t>(b.rgb[i] + (b.rgb[i] > 128 ? -levels : levels));
    }
    return measure_pixels(a, b, nullptr, 0);
  };
  EXPECT_EQ(broken_limit(with_noise(noisy, 3), {}), "");
  EXPECT_HAS(broken_limit(with_noise(noisy, 4), {}), "changed by 4 levels");
  Image all = a;
  for (std::uint8_t& value : all.rgb) value += value < 255;
  EXPECT_HAS(broken_limit(measure_pixels(a, all, nullptr, 0), {}), "100 % of the pixels changed");
}

TEST(PixelLimits, EachIsNamed) {
  const PixelMeasures m = measure_pixels(pattern(), changed_pattern(), nullptr, 0);
  PixelLimits lax;
  lax.share = 1.0, lax.largest = 255;
  EXPECT_EQ(broken_limit(m, lax), "");
  PixelLimits limits = lax;
  limits.rmse = 49.0;
  EXPECT_HAS(broken_limit(m, limits), "RMSE 49.6 levels, 49 allowed");
  limits = lax, limits.ssim = 0.8;
  EXPECT_HAS(broken_limit(m, limits), "SSIM 0.711");
  limits = lax, limits.flip = 0.3;
  EXPECT_HAS(broken_limit(m, limits), "FLIP 0.316");
}

}  // namespace
}  // namespace thew::tests
