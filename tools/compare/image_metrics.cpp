// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/image_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "rig/types.h"
#include "tools/base/text.h"
#include "tools/compare/flip.h"

namespace thew::tools {
namespace {

std::string size_of(const Image& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

bool compared(const Image* mask, std::size_t pixel) {
  if (!mask) return true;
  const std::uint8_t* p = &mask->rgb[3 * pixel];
  return p[0] + p[1] + p[2] >= 3 * 128;
}

double masked_mean(const Plane& plane, const Image* mask) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    if (!compared(mask, i)) continue;
    sum += plane.values[i];
    ++count;
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

// Rec. 601, of the values as they are coded.
Plane luma(const Image& image) {
  Plane plane{image.width, image.height, std::vector<double>(image.rgb.size() / 3)};
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    const std::uint8_t* p = &image.rgb[3 * i];
    plane.values[i] = 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
  }
  return plane;
}

Plane product(const Plane& a, const Plane& b) {
  Plane out = a;
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] *= b.values[i];
  return out;
}

// Pixels [left, right) x [top, bottom).
struct Box {
  int left, top, right, bottom;
  int width() const { return right - left; }
};

// Around all that differs.
Box changed_box(const Image& a, const Image& b) {
  Box box{a.width, a.height, 0, 0};
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const std::size_t at = 3ul * (1ul * a.width * y + x);
      if (std::equal(&a.rgb[at], &a.rgb[at] + 3, &b.rgb[at])) continue;
      box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x + 1),
             std::max(box.bottom, y + 1)};
    }
  }
  return box;
}

Box grown(const Box& box, int by, const Image& image) {
  return {std::max(box.left - by, 0), std::max(box.top - by, 0),
          std::min(box.right + by, image.width), std::min(box.bottom + by, image.height)};
}

Image cropped(const Image& image, const Box& box) {
  Image out{box.width(), box.bottom - box.top, {}};
  for (int y = box.top; y < box.bottom; ++y) {
    const auto row = image.rgb.begin() + 3l * (std::int64_t{1} * image.width * y + box.left);
    out.rgb.insert(out.rgb.end(), row, row + 3l * box.width());
  }
  return out;
}

// A measure of two pictures that goes by the pixels within `reach`: beyond that from `changed` it
// is what `elsewhere` holds.
template <typename Measure>
Plane measured_near(const Image& a, const Image& b, const Box& changed, int reach, Plane elsewhere,
                    const Measure& measure) {
  const Box inner = grown(changed, reach, a), outer = grown(inner, reach, a);
  const Plane part = measure(cropped(a, outer), cropped(b, outer));
  for (int y = inner.top; y < inner.bottom; ++y) {
    const auto from = part.values.begin() + std::int64_t{1} * part.width * (y - outer.top) +
                      (inner.left - outer.left);
    std::copy_n(from, inner.width(),
                elsewhere.values.begin() + std::int64_t{1} * a.width * y + inner.left);
  }
  return elsewhere;
}

Plane plane_of(const Image& image, double value) {
  return {image.width, image.height, std::vector<double>(image.rgb.size() / 3, value)};
}

constexpr int kReach = 5;  // pixels, of a Gaussian of 11 x 11
const std::vector<double>& smooth_taps() {
  static const std::vector<double> kTaps = gaussian(1.5, kReach);
  return kTaps;
}

Plane smoothed(const Plane& plane) { return filter(plane, smooth_taps(), smooth_taps()); }

// SSIM = (2 m_a m_b + C1) (2 s_ab + C2) / ((m_a^2 + m_b^2 + C1) (s_a^2 + s_b^2 + C2)), means m and
// covariances s under a Gaussian of 11 x 11 pixels, deviation 1.5.
Plane structural_similarity(const Image& expected, const Image& actual) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
  const Plane a = luma(expected), b = luma(actual);
  const Plane mean_a = smoothed(a), mean_b = smoothed(b);
  const Plane aa = smoothed(product(a, a)), bb = smoothed(product(b, b)),
              ab = smoothed(product(a, b));
  Plane out = mean_a;
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const double m = mean_a.values[i], n = mean_b.values[i];
    const double variances = aa.values[i] - m * m + bb.values[i] - n * n;
    out.values[i] = (2.0 * m * n + kC1) * (2.0 * (ab.values[i] - m * n) + kC2) /
                    ((m * m + n * n + kC1) * (variances + kC2));
  }
  return out;
}

// The shift d of the whole picture that explains the difference best: b - a = -grad I . d in least
// squares (Lucas and Kanade 1981), I the mean of both. Zero unless it explains more than half.
// Smoothed, since differences of neighbours say too little of how steep a sharp edge is.
Eigen::Vector2d find_shift(const Image& expected, const Image& actual, const Box& changed) {
  const Plane a = smoothed(luma(expected));
  const Plane b = measured_near(expected, actual, changed, kReach, a,
                                [](const Image&, const Image& i) { return smoothed(luma(i)); });
  const std::vector<double> slope = {-0.5, 0.0, 0.5}, here = {1.0};
  Plane mean = a;
  for (std::size_t i = 0; i < mean.values.size(); ++i) {
    mean.values[i] = 0.5 * (a.values[i] + b.values[i]);
  }
  const Plane gx = filter(mean, slope, here), gy = filter(mean, here, slope);
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Identity() * 1e-9;
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double all = 0.0, left = 0.0;
  for (std::size_t i = 0; i < mean.values.size(); ++i) {
    const Eigen::Vector2d g(gx.values[i], gy.values[i]);
    const double change = b.values[i] - a.values[i];
    matrix += g * g.transpose();
    right -= change * g;
    all += change * change;
  }
  const Eigen::Vector2d shift = matrix.inverse() * right;
  for (std::size_t i = 0; i < mean.values.size(); ++i) {
    const double change = b.values[i] - a.values[i];
    const double rest = change + gx.values[i] * shift.x() + gy.values[i] * shift.y();
    left += rest * rest;
  }
  return left < 0.5 * all ? shift : Eigen::Vector2d(Eigen::Vector2d::Zero());
}

}  // namespace

Image masked(const Image& expected, Image actual, const Image* mask) {
  for (std::size_t i = 0; i < actual.rgb.size() / 3; ++i) {
    if (!compared(mask, i)) std::copy_n(&expected.rgb[3 * i], 3, &actual.rgb[3 * i]);
  }
  return actual;
}

PixelMeasures measure_pixels(const Image& expected, const Image& actual_unmasked, const Image* mask,
                             int threshold) {
  for (const Image* other : {&actual_unmasked, mask}) {
    if (!other || (other->width == expected.width && other->height == expected.height)) continue;
    throw Error(ErrorCode::kInput, std::string(other == mask ? "the mask" : "the picture") +
                                       " is " + size_of(*other) + " pixels, expected " +
                                       size_of(expected) + "; give one of the same size");
  }
  const std::size_t pixels = expected.rgb.size() / 3;
  std::size_t count = 0, changed = 0;
  for (std::size_t i = 0; i < pixels; ++i) count += compared(mask, i);
  if (count == 0) {
    throw Error(ErrorCode::kInput,
                "the mask is dark everywhere: nothing is compared; paint white "
                "what is to be compared");
  }
  // What is masked is made the same, so that windows across the mask's border see nothing of it.
  const Image actual = masked(expected, actual_unmasked, mask);
  PixelMeasures measures;
  if (actual.rgb == expected.rgb) return measures;
  double squares = 0.0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!compared(mask, i)) continue;
    int difference = 0;
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      const int d = std::abs(int{actual.rgb[k]} - int{expected.rgb[k]});
      difference = std::max(difference, d);
      squares += d * d;
    }
    if (difference > threshold) ++changed;
    if (difference <= measures.largest) continue;
    measures.largest = difference;
    measures.x = static_cast<int>(i % actual.width);
    measures.y = static_cast<int>(i / actual.width);
  }
  measures.share = static_cast<double>(changed) / static_cast<double>(count);
  measures.rmse = std::sqrt(squares / (3.0 * static_cast<double>(count)));
  const Box box = changed_box(expected, actual);
  const auto mean_of = [&](int reach, double same, const auto& measure) {
    return masked_mean(
        measured_near(expected, actual, box, reach, plane_of(expected, same), measure), mask);
  };
  measures.ssim = mean_of(kReach, 1.0, structural_similarity);
  measures.flip =
      mean_of(flip_reach(), 0.0, [](const Image& a, const Image& b) { return flip(a, b); });
  const Eigen::Vector2d shift = find_shift(expected, actual, box);
  measures.shift_x = shift.x(), measures.shift_y = shift.y();
  return measures;
}

std::string broken_limit(const PixelMeasures& measures, const PixelLimits& limits) {
  if (measures.share > limits.share) {
    return readable(100.0 * measures.share) + " % of the pixels changed, " +
           readable(100.0 * limits.share) + " % allowed";
  }
  if (measures.largest > limits.largest) {
    return "a pixel changed by " + std::to_string(measures.largest) + " levels, " +
           std::to_string(limits.largest) + " allowed";
  }
  if (limits.rmse && measures.rmse > *limits.rmse) {
    return "RMSE " + readable(measures.rmse) + " levels, " + readable(*limits.rmse) + " allowed";
  }
  if (limits.ssim && measures.ssim < *limits.ssim) {
    return "SSIM " + readable(measures.ssim, 4) + ", at least " + readable(*limits.ssim, 4) +
           " asked for";
  }
  if (limits.flip && measures.flip > *limits.flip) {
    return "FLIP " + readable(measures.flip) + ", " + readable(*limits.flip) + " allowed";
  }
  return "";
}

Image heat_map(const Plane& error) {
  Image image{error.width, error.height, {}};
  image.rgb.reserve(3 * error.values.size());
  for (const double value : error.values) {
    // The root, so that slight differences are seen as well.
    const double heat = 3.0 * std::sqrt(std::clamp(value, 0.0, 1.0));
    for (int k = 0; k < 3; ++k) {
      image.rgb.push_back(static_cast<std::uint8_t>(255.0 * std::clamp(heat - k, 0.0, 1.0) + 0.5));
    }
  }
  return image;
}

}  // namespace thew::tools
