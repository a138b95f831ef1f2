// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

inline constexpr int kMostZones = 16;

/// A body divided along its axis into k zones that overlap, each of which is to keep its volume
/// (after the zonal constraints of Sheen, Larionov, Pai 2021, there on finite elements; here a
/// surface alone is known). Zone j weighs a place by before_j+1 - before_j, where before_c falls
/// smoothly from 1 to 0 across cut c, is 1 for the cut beyond the end and 0 for the one before the
/// beginning: all of them sum to 1.
///
/// L_c, the volume before cut c, is that of the surface before it, closed by the cone from its rim
/// to a_c, the centre of the section's nodes. A cone's triangles see a_c edge on, so that
///   L_c = sum over triangles t of before_c(t) det(x1 - a_c, x2 - a_c, x3 - a_c) / 6,
/// with before_c(t) the mean of the corners', and a_c = sum over nodes of centre_c(i) x_i. Where
/// before_c is a step that is the volume of a closed polyhedron; a smooth one is the mean of such
/// polyhedra over the section's width. So L_c is a cubic in the nodes, rigid motion leaves it as it
/// is, and a bent or a squeezed body's sections go along with its material. Zone j holds
/// L_j+1 - L_j; the zones sum to the enclosed volume exactly.
struct VolumeZones {
  struct Cut {
    struct Part {
      int triangle;
      double before;  ///< how much of it counts: 0 < before <= 1
    };
    struct Share {
      int node;
      double centre;  ///< of the section's centre; all sum to 1
    };
    std::vector<Part> parts;
    std::vector<Share> section;
  };
  std::vector<Cut> cuts;            ///< k - 1
  std::vector<double> rest_before;  ///< m^3: L of each cut at rest, then all; empty: one zone

  int count() const { return static_cast<int>(rest_before.size()); }
};

/// Divides by the nodes' axis coordinates `along` in 0..1, at equal distances.
/// std::invalid_argument where a section has no node, or a zone no volume at rest.
VolumeZones make_volume_zones(const TriMesh& rest, const std::vector<double>& along, int count);

/// Coordinates 0..1 along a body's longest axis: the direction in which its nodes spread most.
std::vector<double> longest_axis_coordinates(const TriMesh& mesh);

/// L_c (m^3) of each cut, then the enclosed volume.
void volumes_before(const VolumeZones& zones, const Points& x,
                    const std::vector<Triangle>& triangles, std::vector<double>& before);
/// Their derivatives (m^2), one row per node.
void gradients_before(const VolumeZones& zones, const Points& x,
                      const std::vector<Triangle>& triangles, std::vector<Points>& gradients);

/// Largest error of a zone's volume, relative to its own at rest.
double zone_error(const VolumeZones& zones, const std::vector<double>& before,
                  const std::vector<double>& wanted);

/// Kept so that a step does not allocate.
struct ZoneScratch {
  std::vector<double> before;
  std::vector<Points> gradients;
  Points start;
};
/// Moves x along the directions, one for each cut and one for all, to where the volumes before the
/// cuts are `wanted` (m^3), by Newton on the k x k system. False, and x as it was, where that does
/// not converge: no motion along them changes a zone that is wrong, or there is no such shape near.
bool restore_zones(const VolumeZones& zones, const std::vector<Triangle>& triangles,
                   const std::vector<double>& wanted, const std::vector<Points>& directions,
                   ZoneScratch& scratch, Points& x);

}  // namespace thew::muscles
