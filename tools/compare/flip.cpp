// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/flip.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "rig/math.h"

namespace thew::tools {
namespace {

// The paper's constants.
constexpr double kColourExponent = 0.7, kFeatureExponent = 0.5;      // q_c, q_f
constexpr double kKnee = 0.4, kKneeHeight = 0.95;                    // p_c, p_t
constexpr double kFeatureWidth = 0.082;                              // w, degrees
constexpr double kAchromatic = 0.0047, kRedGreen = 0.0053;           // b_1 of the CSFs, degrees^2
constexpr double kBlueYellow[2][2] = {{34.1, 0.04}, {13.5, 0.025}};  // a_i, b_i

using Planes = std::array<Plane, 3>;

// sRGB's primaries and D65; a row's sum is the white point's X, Y or Z.
const Mat3& xyz_from_rgb() {
  static const Mat3 kMatrix =
      (Mat3() << 10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,
       2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897, 1425312.0 / 73733382,
       8788810.0 / 73733382, 70074185.0 / 73733382)
          .finished();
  return kMatrix;
}

// XYZ over the white point.
Vec3 relative_xyz(const Vec3& rgb) {
  static const Mat3 kMatrix =
      (xyz_from_rgb() * Vec3::Ones()).cwiseInverse().asDiagonal() * xyz_from_rgb();
  return kMatrix * rgb;
}

Vec3 rgb_of_relative(const Vec3& xyz) {
  static const Mat3 kMatrix =
      xyz_from_rgb().inverse() * (xyz_from_rgb() * Vec3::Ones()).asDiagonal();
  return kMatrix * xyz;
}

// Lightness and two opponent colours from XYZ over white: L*a*b* of its roots, YCxCz of itself.
Vec3 opponent(const Vec3& t) {
  return {116.0 * t.y() - 16.0, 500.0 * (t.x() - t.y()), 200.0 * (t.y() - t.z())};
}

Vec3 relative_of_opponent(const Vec3& c) {
  const double y = (c.x() + 16.0) / 116.0;
  return {y + c.y() / 500.0, y, y - c.z() / 200.0};
}

// L*a*b* of a linear colour, with Hunt's adjustment: colours in the dark look less colourful.
Vec3 hunt_lab(const Vec3& rgb) {
  constexpr double kDelta = 6.0 / 29.0;
  const Vec3 root = relative_xyz(rgb).unaryExpr([&](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
  });
  const Vec3 lab = opponent(root);
  return {lab.x(), 0.01 * lab.x() * lab.y(), 0.01 * lab.x() * lab.z()};
}

// HyAB (Abasi 2020), to the power q_c.
double colour_distance(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  return std::pow(std::abs(d.x()) + std::hypot(d.y(), d.z()), kColourExponent);
}

// To 0..1: small differences share most of the range.
double redistribute(double distance) {
  static const double kMost = colour_distance(hunt_lab(Vec3::UnitY()), hunt_lab(Vec3::UnitZ()));
  const double knee = kKnee * kMost;
  if (distance < knee) return kKneeHeight / knee * distance;
  return kKneeHeight + (distance - knee) / (kMost - knee) * (1.0 - kKneeHeight);
}

Planes opponent_planes(const Image& image) {
  std::array<double, 256> linear;
  for (int i = 0; i < 256; ++i) {
    const double c = i / 255.0;
    linear[i] = c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92;
  }
  const Plane empty{image.width, image.height, std::vector<double>(image.rgb.size() / 3)};
  Planes planes{empty, empty, empty};
  for (std::size_t i = 0; i < empty.values.size(); ++i) {
    const std::uint8_t* p = &image.rgb[3 * i];
    const Vec3 colour = opponent(relative_xyz({linear[p[0]], linear[p[1]], linear[p[2]]}));
    for (int k = 0; k < 3; ++k) planes[k].values[i] = colour[k];
  }
  return planes;
}

// A contrast sensitivity S(rho) = a exp(-b rho^2) is in space a Gaussian of a deviation of
// sqrt(b / 2) / pi degrees, a sqrt(pi / b) high.
double deviation(double b, double pixels_per_degree) {
  return std::sqrt(0.5 * b) / kPi * pixels_per_degree;
}

int colour_reach(double pixels_per_degree) {  // of the widest Gaussian
  return static_cast<int>(std::ceil(3.0 * deviation(kBlueYellow[0][1], pixels_per_degree)));
}

double feature_deviation(double pixels_per_degree) {
  return 0.5 * kFeatureWidth * pixels_per_degree;
}

int feature_reach(double pixels_per_degree) {
  return static_cast<int>(std::ceil(3.0 * feature_deviation(pixels_per_degree)));
}

// What the eye still resolves, as linear RGB in 0..1.
std::vector<Vec3> seen_colours(const Planes& planes, double pixels_per_degree) {
  const int radius = colour_reach(pixels_per_degree);
  const auto blur = [&](const Plane& plane, double b) {
    const auto taps = gaussian(deviation(b, pixels_per_degree), radius);
    return filter(plane, taps, taps);
  };
  const Plane light = blur(planes[0], kAchromatic), red_green = blur(planes[1], kRedGreen);
  Plane blue_yellow;
  double sum = 0.0;
  for (const auto& [a, b] : kBlueYellow) {
    // What this Gaussian has of the whole kernel, cut off at the radius as it is.
    double reach = 0.0;
    for (int x = -radius; x <= radius; ++x) {
      reach += std::exp(-0.5 * std::pow(x / deviation(b, pixels_per_degree), 2));
    }
    const double share = a * std::sqrt(kPi / b) * reach * reach;
    const Plane part = blur(planes[2], b);
    blue_yellow.values.resize(part.values.size(), 0.0);
    for (std::size_t i = 0; i < part.values.size(); ++i) {
      blue_yellow.values[i] += share * part.values[i];
    }
    sum += share;
  }
  std::vector<Vec3> colours(light.values.size());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const Vec3 c(light.values[i], red_green.values[i], blue_yellow.values[i] / sum);
    colours[i] = rgb_of_relative(relative_of_opponent(c)).cwiseMax(0.0).cwiseMin(1.0);
  }
  return colours;
}

// A derivative's taps: what is positive sums to 1, what is negative to -1.
std::vector<double> balanced(std::vector<double> taps) {
  double positive = 0.0, negative = 0.0;
  for (const double tap : taps) (tap > 0.0 ? positive : negative) += tap;
  for (double& tap : taps) tap /= tap > 0.0 ? positive : -negative;
  return taps;
}

struct Features {
  Plane edges, points;
};

// Size of the first and the second derivative of the lightness under a Gaussian.
Features find_features(Plane light, double pixels_per_degree) {
  for (double& value : light.values) value = (value + 16.0) / 116.0;
  const double sd = feature_deviation(pixels_per_degree);
  const int radius = feature_reach(pixels_per_degree);
  const std::vector<double> smooth = gaussian(sd, radius);
  std::vector<double> first = smooth, second = smooth;
  for (int x = -radius; x <= radius; ++x) {
    first[x + radius] *= -x;
    second[x + radius] *= x * x / (sd * sd) - 1.0;
  }
  const auto size = [&](const std::vector<double>& taps) {
    Plane along = filter(light, taps, smooth);
    const Plane down = filter(light, smooth, taps);
    for (std::size_t i = 0; i < along.values.size(); ++i) {
      along.values[i] = std::hypot(along.values[i], down.values[i]);
    }
    return along;
  };
  return {size(balanced(first)), size(balanced(second))};
}

}  // namespace

int flip_reach(double pixels_per_degree) {
  return std::max(colour_reach(pixels_per_degree), feature_reach(pixels_per_degree));
}

Plane flip(const Image& expected, const Image& actual, double pixels_per_degree) {
  assert(expected.width == actual.width && expected.height == actual.height);
  const Planes a = opponent_planes(expected), b = opponent_planes(actual);
  const std::vector<Vec3> seen_a = seen_colours(a, pixels_per_degree),
                          seen_b = seen_colours(b, pixels_per_degree);
  const Features features_a = find_features(a[0], pixels_per_degree),
                 features_b = find_features(b[0], pixels_per_degree);
  Plane error{expected.width, expected.height, std::vector<double>(seen_a.size())};
  for (std::size_t i = 0; i < seen_a.size(); ++i) {
    const double colour = redistribute(colour_distance(hunt_lab(seen_a[i]), hunt_lab(seen_b[i])));
    const double feature =
        std::max(std::abs(features_a.edges.values[i] - features_b.edges.values[i]),
                 std::abs(features_a.points.values[i] - features_b.points.values[i]));
    error.values[i] = std::pow(colour, 1.0 - std::pow(std::sqrt(0.5) * feature, kFeatureExponent));
  }
  return error;
}

}  // namespace thew::tools
