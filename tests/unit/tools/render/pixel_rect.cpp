// SPDX-License-Identifier: Apache-2.0
#include "tools/render/pixel_rect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace thew::tests {
namespace {

constexpr int kWidth = 160, kHeight = 90;

bool holds(const PixelRect& rect, double x, double y) {
  return x >= rect.left && x <= rect.right && y >= rect.bottom && y <= rect.top;
}

bool is_whole(const PixelRect& rect) {
  return rect.left == 0 && rect.bottom == 0 && rect.right == kWidth && rect.top == kHeight;
}

// A slanting rod of 100 points, near and far, and how it is seen.
class Rects : public ::testing::Test {
 protected:
  Rects() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> within(-1.0, 1.0);
    for (int i = 0; i < 100; ++i) {
      const double along = within(random);
      points_.push_back(Vec3(0.2 * along, 0.3 + 0.2 * along, 0.1 * along) +
                        0.02 * Vec3(within(random), within(random), within(random)));
      seen_.add(points_.back());
    }
    view_.eye = Vec3(0.3, 0.9, 2.0);
    view_.target = Vec3(0.1, 0.1, 0);
  }
  Camera camera() const { return make_camera(view_, double(kWidth) / kHeight, seen_); }
  Light light() const { return make_light(view_, camera(), seen_, seen_.radius()); }
  // In pixels from the lower left corner.
  static Eigen::Vector2d project(const Camera& camera, const Vec3& p) {
    const Vec3 q = camera.view_from_world * p;
    return {0.5 * (1.0 - q.x() / (q.z() * camera.tan_x)) * kWidth,
            0.5 * (1.0 - q.y() / (q.z() * camera.tan_y)) * kHeight};
  }
  PixelRect ground_of(double blur) const {
    const Camera from = camera();
    const Light lit = light();
    ShadowOutline outline(lit);
    for (const Vec3& p : points_) outline.add(p);
    return outline.on_ground(kGround, blur, from, kWidth, kHeight);
  }

  static constexpr double kGround = 0.0;  // m, height
  SceneView view_;
  std::vector<Vec3> points_;
  Bounds seen_;
};

TEST_F(Rects, HoldWhatIsSeenAndLittleMore) {
  const Camera from = camera();
  SeenRect figure(from, kWidth, kHeight);
  EXPECT_TRUE(figure.rect().empty());
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (const Vec3& p : points_) {
    figure.add(p);
    low = low.min(project(from, p).array());
    high = high.max(project(from, p).array());
  }
  const PixelRect rect = figure.rect();
  for (const Vec3& p : points_) {
    const Eigen::Vector2d at = project(from, p);
    EXPECT_TRUE(holds(rect, at.x(), at.y())) << at.transpose();
  }
  EXPECT_LE(low.x() - rect.left, 2.0);
  EXPECT_LE(low.y() - rect.bottom, 2.0);
  EXPECT_LE(rect.right - high.x(), 2.0);
  EXPECT_LE(rect.top - high.y(), 2.0);
  EXPECT_LT(rect.area(), 0.3 * kWidth * kHeight);
}

TEST_F(Rects, EndAtThePicture) {
  const Camera from = camera();
  SeenRect figure(from, kWidth, kHeight);
  for (const double x : {-5.0, 5.0}) figure.add(Vec3(x, 0.2, 0));
  const PixelRect rect = figure.rect();
  EXPECT_EQ(rect.left, 0);
  EXPECT_EQ(rect.right, kWidth);
  EXPECT_LT(rect.height(), kHeight / 2);
}

TEST_F(Rects, TakeTheWholePictureAboutTheEye) {
  const Camera from = camera();
  SeenRect figure(from, kWidth, kHeight);
  figure.add(points_[0]);
  figure.add(view_.eye + 0.1 * (view_.eye - view_.target));
  EXPECT_TRUE(is_whole(figure.rect()));
}

// The rays of light through every point, and through what lies as far from it as the blur takes.
TEST_F(Rects, HoldTheShadowOnTheGround) {
  const double blur = 8.0;
  for (const Vec3& towards : {Vec3(0.2, 1, 0.1), Vec3(-0.3, 0.6, 0.2), Vec3(0.1, 0.5, 0.3)}) {
    view_.light = towards;
    const Camera from = camera();
    const Light lit = light();
    const PixelRect rect = ground_of(blur);
    Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
    for (const Vec3& p : points_) {
      const Vec3 x = lit.direction.unitOrthogonal(), y = lit.direction.cross(x);
      for (const auto& [i, j] : {std::pair(1, 1), {1, -1}, {-1, 1}, {-1, -1}}) {
        const Vec3 q = p + blur * lit.texel * (i * x + j * y);
        const Vec3 on = q - (q.y() - kGround) / lit.direction.y() * lit.direction;
        const Eigen::Vector2d at = project(from, on);
        low = low.min(at.array());
        high = high.max(at.array());
        EXPECT_TRUE(holds(rect, at.x(), at.y())) << at.transpose();
      }
    }
    ASSERT_FALSE(is_whole(rect));
    EXPECT_LT(rect.width(), 1.4 * (high - low).x() + 5.0) << towards.transpose();
    EXPECT_LT(rect.height(), 1.4 * (high - low).y() + 5.0) << towards.transpose();
  }
}

// Where a float is coarse, the driver puts points elsewhere.
TEST_F(Rects, AreWiderFarOut) {
  const Vec3 far(1e4, 0, 0);
  const auto width_at = [&](const Vec3& place) {
    SceneView view = view_;
    view.eye += place;
    view.target += place;
    const Camera from = make_camera(view, double(kWidth) / kHeight, seen_);
    SeenRect figure(from, kWidth, kHeight);
    for (const Vec3& p : points_) figure.add(p + place);
    return figure.rect().width();
  };
  const int near = width_at(Vec3::Zero()), pixel = static_cast<int>(0.005 / 0.0125) + 1;
  EXPECT_GE(width_at(far), near + pixel);
  EXPECT_LT(width_at(far), near + 10 * pixel);
}

TEST_F(Rects, TakeTheWholePictureForTheShadowOfALowLight) {
  for (const Vec3& towards : {Vec3(1, 0.005, 0), Vec3(1, -0.5, 0)}) {
    view_.light = towards;
    EXPECT_TRUE(is_whole(ground_of(8.0))) << towards.transpose();
  }
}

TEST_F(Rects, TakeTheWholePictureWhereTheShadowMapEnds) {
  view_.light = Vec3(0.2, 1, 0.1);
  const Light lit = light();
  points_.push_back(seen_.centre() + 1.05 * seen_.radius() * lit.direction.unitOrthogonal());
  const Camera from = camera();
  ShadowOutline outline(lit);
  for (const Vec3& p : points_) outline.add(p);
  EXPECT_TRUE(is_whole(outline.on_ground(kGround, 8.0, from, kWidth, kHeight)));
}

}  // namespace
}  // namespace thew::tests
