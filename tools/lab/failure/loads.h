// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/model.h"
#include "tools/lab/elements/delaunay.h"

namespace thew::tools {

/// What is varied against the step.
enum class Load { kStiffness, kWeights, kSqueeze, kTwist, kStrike, kOverlap, kEdges };
struct Quantity {
  Load load;
  const char *name, *unit;
  std::vector<double> columns;
};
const std::vector<Quantity>& map_quantities();

/// A scene's first muscle by itself: longest along x, thinnest along y, about the origin.
struct MapBody {
  TriMesh mesh;
  Vec3 size;  ///< m
  SpringMaterial material;
  TetMesh solid;  ///< the same filled, its surface's nodes first; none where it is no ellipsoid
};
/// Error(kUsage) where the scene has no muscle, or one of more than 2,000 nodes.
MapBody map_body(const std::filesystem::path& scene);

/// The body under a load's value that changes its mesh: from one end of some edges, as many as do
/// not meet, to the other is `value` % of the way; no triangle or tetrahedron turns over, they
/// become thin. Else as it is.
MapBody loaded_body(const MapBody& body, Load load, double value);

inline constexpr double kPhase = 0.6;     ///< s: to the load, there, back, at rest
inline constexpr double kMapDrag = 20.0;  ///< 1/s

/// Each plane's way (m) or the right hand's turn (rad), straight from key to key.
struct LoadWay {
  std::vector<double> times, values;
  double at(double time) const;
};
LoadWay load_way(const MapBody& body, Load load, double value);

/// Nodes that hands hold under a twist: 1 the left one, 2 the right one, else 0.
std::vector<char> held_nodes(const MapBody& body, const std::vector<Vec3>& nodes);

/// As Thew's scene: two planes that close along y, two hands that turn about x.
Model map_model(const MapBody& body, Load load, double value);

}  // namespace thew::tools
