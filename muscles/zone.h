// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Automatic deformation zone (paper eq. 15, mended by pi): W = (cos(pi d / r) + 1) / 2 for d < r,
/// 0 beyond, d the distance along the surface from the loaded nodes.
struct ZoneSettings {
  double smallest_radius = 0.0;  ///< m
  double largest_radius = 1e9;   ///< m, the user's threshold
  double per_impulse = 0.0;      ///< m per N s: growth with amount and duration of the load
  double along_load = 0.0;       ///< 0..1: stretch of the zone towards the load's direction
};

/// Which nodes of a mesh are linked: along an edge, or across one, from one of the vertices
/// opposite it to the other.
struct SurfaceLinks {
  struct Pair {
    std::array<int, 2> ends, edge;  ///< edge: what lies between; {-1, -1}: nothing
  };
  struct Link {
    int to, pair;
  };
  std::vector<Pair> pairs;
  std::vector<int> first;  ///< of node i: links first[i] to first[i + 1]
  std::vector<Link> links;
};
SurfaceLinks surface_links(const TriMesh& mesh);

/// Scratch: as long as it gets after the first step that uses it.
struct ZoneWork {
  std::vector<int> loaded;  ///< nodes
  std::vector<Vec3> x;
  std::vector<double> lengths;  ///< m, by pair
  std::vector<std::pair<double, int>> front;
};

/// Shortest distance (m) along the surface from any of the sources; edges and the unfolded
/// diagonals across them. Unreached nodes get infinity.
void surface_distance(const SurfaceLinks& links, const std::vector<Vec3>& x,
                      const std::vector<int>& sources, ZoneWork& work,
                      std::vector<double>& distance);

/// Radius after a load (N) has acted for one more step: grows by per_impulse * load * dt, capped.
double grown_radius(const ZoneSettings& settings, double radius, double load, double dt);

/// Eq. 15 itself: 1 at distance 0, 0 from the radius on.
double zone_weight(double distance, double radius);

/// Weights of the zone around work.loaded, at least one node, normalised to sum n.
/// `load_direction` (unit or zero) shortens distances along it by 1 - along_load.
void zone_weights(const SurfaceLinks& links, const std::vector<Vec3>& rest,
                  const Vec3& load_direction, const ZoneSettings& settings, double radius,
                  ZoneWork& work, std::vector<double>& weights);

}  // namespace thew::muscles
