// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Automatic deformation zone (paper, eq. 15, which is printed without pi): W = (cos(pi d / r) + 1)
/// / 2 for d < r and 0 beyond, with d the distance along the surface from the loaded nodes.
struct ZoneSettings {
  double smallest_radius = 0.0;  ///< m
  double largest_radius = 1e9;   ///< m, limit that the user sets
  double per_impulse = 0.0;      ///< m per N s: growth of the radius with the load and its duration
  double along_load = 0.0;       ///< 0..1: stretch of the zone along the direction of the load
};

/// Links between the nodes of a mesh: along each edge, and across each edge between the two
/// vertices opposite it.
struct SurfaceLinks {
  struct Pair {
    std::array<int, 2> ends, edge;  ///< edge: the edge that lies between the ends; {-1, -1}: none
  };
  struct Link {
    int to, pair;
  };
  std::vector<Pair> pairs;
  std::vector<int> first;  ///< of node i: links first[i] to first[i + 1]
  std::vector<Link> links;
};
SurfaceLinks surface_links(const TriMesh& mesh);

/// Scratch, which does not grow after the first step that uses it.
struct ZoneWork {
  std::vector<int> loaded;  ///< nodes
  std::vector<Vec3> x;
  std::vector<double> lengths;  ///< m, by pair
  std::vector<std::pair<double, int>> front;
};

/// Sets `distance` (m) to the shortest path from any of the sources along edges and along the
/// diagonals across edges, in the plane into which their two triangles unfold. Nodes that are not
/// reached get infinity.
void surface_distance(const SurfaceLinks& links, const std::vector<Vec3>& x,
                      const std::vector<int>& sources, ZoneWork& work,
                      std::vector<double>& distance);

/// The radius (m) after a load (N) has acted for dt (s) more: it grows by per_impulse load dt,
/// within its limits.
double grown_radius(const ZoneSettings& settings, double radius, double load, double dt);

/// The weight by eq. 15: 1 at distance 0, 0 from the radius on (both in m).
double zone_weight(double distance, double radius);

/// Weights of the zone around the nodes work.loaded, at least one, scaled so that they sum to the
/// number of nodes. Distances along `load_direction` (unit or zero) are multiplied by 1 -
/// along_load.
void zone_weights(const SurfaceLinks& links, const std::vector<Vec3>& rest,
                  const Vec3& load_direction, const ZoneSettings& settings, double radius,
                  ZoneWork& work, std::vector<double>& weights);

}  // namespace thew::muscles
