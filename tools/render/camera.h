// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "rig/types.h"
#include "sim/scene/scene.h"

namespace thew::tools {

using Mat4 = Eigen::Matrix4d;

inline constexpr int kShadowSize = 1024;  ///< texels of the shadow map, each way

struct Camera {
  Transform view_from_world;
  Mat4 clip_from_view;
  double tan_x, tan_y, near, far;
};

struct Light {
  Vec3 direction;  // towards it, in the world
  Mat4 light_from_world;
  double texel;  // m
};

/// Box and the ball around it.
struct Bounds {
  Vec3 low = Vec3::Constant(1e30), high = Vec3::Constant(-1e30);
  bool empty() const { return low.x() > high.x(); }
  void add(const Vec3& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  Vec3 centre() const { return empty() ? Vec3(Vec3::Zero()) : Vec3(0.5 * (low + high)); }
  double radius() const { return empty() ? 0.0 : std::max(0.5 * (high - low).norm(), 1e-6); }
};

/// Error(kUsage) for a view that shows nothing known or looks nowhere.
void check_view(const SceneView& view);
Camera make_camera(const SceneView& view, double aspect, const Bounds& seen);
/// The shadow map covers a ball about what is seen. Its size grows in steps and its centre moves by
/// whole texels, so that shadows do not crawl from frame to frame.
Light make_light(const SceneView& view, const Camera& camera, const Bounds& seen,
                 double rest_radius);

}  // namespace thew::tools
