// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/skeleton.h"
#include "skin/contact.h"

namespace thew {

struct SkinSettings {
  double thickness = 0.002;  ///< m, least distance of the skin's nodes from muscle and bone
  double smoothing = 0.5;    ///< 0..1, resistance to bending and stretch against the bound shape
  int iterations = 12;       ///< projections in each step
  double fold_gap = 5e-4;    ///< m, kept between skin and skin
};

/// What never changes: topology, rest shape, binding to the bodies.
struct SkinModel {
  Surface surface;
  Rows rest;                                  ///< in the bind pose, world
  std::vector<std::array<int, 4>> bodies;     ///< -1: unused
  std::vector<std::array<double, 4>> shares;  ///< sum 1
  Pose bind_pose;
  SkinSettings settings;
};

struct SkinState {
  Rows x;
  Bvh bvh;
};

struct SkinMetrics {
  double max_penetration = 0.0;   ///< m, skin nodes inside muscle or bone
  double max_poke_through = 0.0;  ///< m, muscle or bone nodes outside the skin
  int intersecting_pairs = 0;     ///< skin with itself
};

/// `below` are bones and muscles in the bind pose, `bodies_of` the body that carries each collider
/// (muscles: -1). Shares follow the distance to the bodies' bones, smoothed over the surface.
SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings);
SkinState initial_skin(const SkinModel& model);

/// Moves the skin to the pose: bound shape, elastic smoothing, contact with what is below, contact
/// with itself. The result depends on the state before alone.
void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               SkinState& state);

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state);

}  // namespace thew
