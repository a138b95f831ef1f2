// SPDX-License-Identifier: Apache-2.0
#include "tools/render/pixel_rect.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

// m by which single precision may move a point when the driver turns it into another space: eight
// roundings of half a last place, a 2^24th, of each coordinate.
double rounding(const Vec3& point) { return 5e-7 * point.lpNorm<1>(); }

}  // namespace

std::vector<PixelRect> few(const PixelRect& a, const PixelRect& b) {
  if (a.empty() || b.empty()) return {a.empty() ? b : a};
  const PixelRect both{std::min(a.left, b.left), std::min(a.bottom, b.bottom),
                       std::max(a.right, b.right), std::max(a.top, b.top)};
  if (a.area() + b.area() < both.area()) return {a, b};
  return {both};
}

void SeenRect::add(const Vec3& point) {
  const Vec3 p = camera_.view_from_world * point;
  const double r = rounding(point), least = -p.z() - r, most = -p.z() + r;
  if (!(least > 1e-3 * camera_.near)) {
    beside_eye_ = true;
    return;
  }
  const Eigen::Array2d tangents(camera_.tan_x, camera_.tan_y), at = p.head<2>().array();
  const Eigen::Array2d low = at - r, high = at + r;
  low_ = low_.min((low / least).min(low / most) / tangents);
  high_ = high_.max((high / least).max(high / most) / tangents);
}

PixelRect SeenRect::rect() const {
  if (beside_eye_) return {0, 0, width_, height_};
  if (low_.x() > high_.x()) return {};
  const auto pixel = [](double at, int size, int more) {  // -1..1 to 0..size
    const double x = std::floor(0.5 * (std::clamp(at, -1.0, 1.0) + 1.0) * size);
    return std::clamp(static_cast<int>(x) + more, 0, size);
  };
  return {pixel(low_.x(), width_, -1), pixel(low_.y(), height_, -1), pixel(high_.x(), width_, 2),
          pixel(high_.y(), height_, 2)};
}

void ShadowOutline::add(const Vec3& point) {
  const Eigen::Vector2d p = light_.light_from_world.topLeftCorner<2, 3>() * point +
                            light_.light_from_world.topRightCorner<2, 1>();
  const Eigen::Array4d along(p.x(), p.y(), p.x() + p.y(), p.x() - p.y());
  low_ = low_.min(along);
  high_ = high_.max(along);
  rounding_ = std::max(rounding_, rounding(point));
}

PixelRect ShadowOutline::on_ground(double height, double blur, const Camera& camera,
                                   int picture_width, int picture_height) const {
  if (low_[0] > high_[0]) return {};
  const double texel = 2.0 / kShadowSize, more = (blur + rounding_ / light_.texel) * texel;
  const Eigen::Array4d wider(more, more, 2.0 * more, 2.0 * more);
  const Eigen::Array4d low = low_ - wider, high = high_ + wider;
  // What touches the map's edge shades all that lies beyond it; a low light's shadow has no end.
  const bool at_edge = std::max(high_.head<2>().maxCoeff(), -low_.head<2>().minCoeff()) >
                       1.0 - (2.0 + rounding_ / light_.texel) * texel;
  if (at_edge || light_.direction.y() < 1e-2) return {0, 0, picture_width, picture_height};
  const double corners[8][2] = {{low[0], low[2] - low[0]},    {low[0], low[0] - low[3]},
                                {high[0], high[2] - high[0]}, {high[0], high[0] - high[3]},
                                {low[2] - low[1], low[1]},    {high[3] + low[1], low[1]},
                                {high[2] - high[1], high[1]}, {low[3] + high[1], high[1]}};
  const Mat4 world_from_light = light_.light_from_world.inverse();
  SeenRect seen(camera, picture_width, picture_height);
  for (const auto& [x, y] : corners) {
    const Vec3 p = (world_from_light * Eigen::Vector4d(x, y, 0.0, 1.0)).head<3>();
    seen.add(p + (height - p.y()) / light_.direction.y() * light_.direction);
  }
  return seen.rect();
}

}  // namespace thew::tools
