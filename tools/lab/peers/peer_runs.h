// SPDX-License-Identifier: Apache-2.0
//
// One run of a scene's muscles, and of the same ball as a soft body of Bullet's.
#pragma once

#include <functional>

#include "muscles/volume.h"
#include "sim/scene/model.h"
#include "tools/lab/base/play.h"
#include "tools/lab/peers/bullet_body.h"

namespace thew::tools {

/// Of one run of all frames.
struct Outcome {
  double milliseconds = 0.0, volume_error = 0.0;  ///< CPU, a frame; largest |V/V0 - 1| at frames
  double equator = 0.0;                           ///< of the ball held at half its height, m
  double contact = 0.0;                           ///< share of the time that finding contacts took
  bool stable = true;
  Points held;  ///< nodes of the ball held at half its height
};
void note_volume(const Points& x, const Muscle& muscle, Outcome& out);

/// Icosahedron, each edge in n parts, on the sphere of the ball's radius: 10 n^2 + 2 nodes.
TriMesh geodesic_ball(int n);

Outcome run_ours(const Model& model, const OnState& on_frame = {});
/// The ball of `assets/paper/ball.toml`, its mesh that of `model`.
Outcome run_our_ball(const Model& model);
Outcome run_bullet_ball(const Model& model, const BulletSetting& setting);
std::string name_of(const BulletSetting& setting);

/// Bullet's most accurate stable setting of a grid with `steps` a frame; stiffer than the first
/// that is unstable is too. Says each on standard error.
struct BestPeer {
  BulletSetting setting;
  double volume_error = 1e300;
};
BestPeer most_accurate(int steps, const std::function<Outcome(const BulletSetting&)>& run);

}  // namespace thew::tools
