// SPDX-License-Identifier: Apache-2.0
#include "tools/render/camera.h"

#include <cmath>
#include <string>

#include "rig/math.h"

namespace thew::tools {
namespace {

constexpr double kKeyDirection[3] = {-0.80, 0.85, 0.62};  // right, world up, towards the eye

}  // namespace

void check_view(const SceneView& view) {
  const auto fail = [&](const std::string& cause) {
    throw Error(ErrorCode::kUsage, "view \"" + view.name + "\": " + cause);
  };
  if (view.show != "skin" && view.show != "muscles" && view.show != "weights" &&
      view.show != "cutaway") {
    fail("show is \"" + view.show + "\"; choose skin, muscles, weights or cutaway");
  }
  const Vec3 line = view.target - view.eye;
  if (!(line.norm() > 1e-9 && line.allFinite())) fail("eye and target coincide; move one of them");
  if (!(line.cross(view.up).norm() > 1e-6 * line.norm() * view.up.norm())) {
    fail("up points along the line of sight; turn it");
  }
  if (!(view.field_of_view >= 1.0 && view.field_of_view <= 150.0)) {
    fail("field_of_view is outside 1..150 degrees; change it");
  }
}

Camera make_camera(const SceneView& view, double aspect, const Bounds& seen) {
  Camera camera;
  const Vec3 back = (view.eye - view.target).normalized();
  const Vec3 right = view.up.cross(back).normalized();
  Mat3 axes;
  axes << right.transpose(), back.cross(right).transpose(), back.transpose();
  camera.view_from_world = Transform::Identity();
  camera.view_from_world.linear() = axes;
  camera.view_from_world.translation() = -(axes * view.eye);
  const SinCos half = sin_cos(0.5 * view.field_of_view * kDegree);
  camera.tan_y = half.sin / half.cos;
  camera.tan_x = camera.tan_y * aspect;
  // As tight about what is seen as depths need, and never behind the eye.
  const double middle = back.dot(view.eye - seen.centre()), radius = 1.05 * seen.radius() + 1e-3;
  camera.far = std::max(middle + radius, 1e-2);
  camera.near = std::max(middle - radius, 2e-3 * camera.far);
  const double n = camera.near, f = camera.far;
  camera.clip_from_view << 1 / camera.tan_x, 0, 0, 0, 0, 1 / camera.tan_y, 0, 0, 0, 0,
      -(f + n) / (f - n), -2 * f * n / (f - n), 0, 0, -1, 0;
  return camera;
}

Light make_light(const SceneView& view, const Camera& camera, const Bounds& seen,
                 double rest_radius) {
  Light light;
  const Mat3 axes = camera.view_from_world.linear();
  const Vec3 right = axes.row(0), back = axes.row(2);
  Vec3 towards =
      kKeyDirection[0] * right + kKeyDirection[1] * Vec3::UnitY() + kKeyDirection[2] * back;
  if (view.light.norm() > 1e-9) towards = view.light;
  light.direction = towards.normalized();
  double radius = std::max(rest_radius, 1e-3);
  while (radius < seen.radius()) radius *= 1.25;
  light.texel = 2.0 * radius / kShadowSize;
  const Vec3 x = light.direction.unitOrthogonal();
  Mat3 turn;
  turn << x.transpose(), light.direction.cross(x).transpose(), light.direction.transpose();
  Vec3 centre = turn * seen.centre();
  for (double& c : centre) c = std::floor(c / light.texel) * light.texel;
  const double span = radius + 2.0 * light.texel;
  light.light_from_world.setIdentity();
  light.light_from_world.topLeftCorner<3, 3>() = Vec3(1, 1, -1).asDiagonal() * turn / span;
  light.light_from_world.topRightCorner<3, 1>() = -(Vec3(1, 1, -1).cwiseProduct(centre) / span);
  return light;
}

}  // namespace thew::tools
