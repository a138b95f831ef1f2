// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"

namespace thew {

/// Automatic deformation zone (paper eq. 15, mended by pi): W = (cos(pi d / r) + 1) / 2 for d < r,
/// 0 beyond, d the distance along the surface from the loaded nodes.
struct ZoneSettings {
  double smallest_radius = 0.0;  ///< m
  double largest_radius = 1e9;   ///< m, the user's threshold
  double per_impulse = 0.0;      ///< m per N s: growth with amount and duration of the load
  double along_load = 0.0;       ///< 0..1: stretch of the zone towards the load's direction
};

/// Shortest distance (m) along the surface from any of the sources; edges and the unfolded
/// diagonals across them. Unreached nodes get infinity.
std::vector<double> surface_distance(const TriMesh& mesh, const std::vector<int>& sources);

/// Radius after a load (N) has acted for one more step: grows by per_impulse * load * dt, capped.
double grown_radius(const ZoneSettings& settings, double radius, double load, double dt);

/// Eq. 15 itself: 1 at distance 0, 0 from the radius on.
double zone_weight(double distance, double radius);

/// Weights of the zone, normalised to sum n. `load_direction` (unit or zero) shortens distances
/// along it by 1 - along_load.
std::vector<double> zone_weights(const TriMesh& mesh, const std::vector<int>& loaded_nodes,
                                 const Vec3& load_direction, const ZoneSettings& settings,
                                 double radius);

}  // namespace thew
