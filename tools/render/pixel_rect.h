// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/render/camera.h"

namespace thew::tools {

/// Pixels [left, right) x [bottom, top) of a picture, rows from the bottom as in GL.
struct PixelRect {
  int left = 0, bottom = 0, right = 0, top = 0;

  int width() const { return right - left; }
  int height() const { return top - bottom; }
  bool empty() const { return width() <= 0 || height() <= 0; }
  double area() const { return empty() ? 0.0 : double{1} * width() * height(); }
};

/// These two, or one around both where that is less to draw.
std::vector<PixelRect> few(const PixelRect& a, const PixelRect& b);

/// Grows to the rectangle of a picture in which points of the world are seen.
class SeenRect {
 public:
  SeenRect(const Camera& camera, int width, int height)
      : camera_(camera), width_(width), height_(height) {}

  void add(const Vec3& point);
  /// With a pixel more on each side for what rounding moves; the whole picture once a point lies
  /// beside or behind the eye, where projection tells nothing.
  PixelRect rect() const;

 private:
  const Camera& camera_;
  int width_, height_;
  bool beside_eye_ = false;
  /// x and y over the distance, in units of the picture's half width and height.
  Eigen::Array2d low_ = Eigen::Array2d::Constant(1e30), high_ = -low_;
};

/// Grows to the outline of points in the shadow map: an octagon, since a rectangle around a limb
/// that lies across it holds mostly nothing.
class ShadowOutline {
 public:
  explicit ShadowOutline(const Light& light) : light_(light) {}

  void add(const Vec3& point);
  /// Where a picture shows ground, the horizontal plane at a `height`, on which they may cast a
  /// shadow that is blurred over `blur` texels of the map.
  PixelRect on_ground(double height, double blur, const Camera& camera, int picture_width,
                      int picture_height) const;

 private:
  const Light& light_;
  /// Of x, y, x + y and x - y, in units of half the map's side.
  Eigen::Array4d low_ = Eigen::Array4d::Constant(1e30), high_ = -low_;
  double rounding_ = 0.0;  ///< m
};

}  // namespace thew::tools
