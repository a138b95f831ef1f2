// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"

namespace thew::muscles {

/// Most zones of a body: bounds the small matrices of restore_zones, which live on the stack.
inline constexpr int kMaxZones = 16;

/// A body divided along its axis into k overlapping zones, each of which is to keep its volume. The
/// idea is that of the zonal constraints of Sheen, Larionov and Pai (2021), who use them on finite
/// elements; here only a surface is known. Zone j has the weight before_(j+1) - before_j at a
/// point, where before_c falls smoothly from 1 to 0 across cut c. before_0 is 0 and before_k is 1
/// everywhere, so the weights of all zones sum to 1.
///
/// L_c, the volume before cut c, is that of the surface before the cut, closed by the cone from its
/// rim to a_c, the centre of the nodes of the section. The triangles of the cone contain a_c, so
/// they add no volume relative to a_c:
///   L_c = sum over triangles t of before_c(t) det(x1 - a_c, x2 - a_c, x3 - a_c) / 6,
/// with before_c(t) the mean of the three corners, and a_c = sum over nodes of centre_c(i) x_i. If
/// before_c is a step function, L_c is the volume of a closed polyhedron; if it is smooth, L_c is
/// the mean of such volumes over the width of the section. So L_c is a cubic in the positions, a
/// rigid motion does not change it, and in a bent or squeezed body the sections move with the
/// material. The volume of zone j is L_(j+1) - L_j, with L_0 = 0 and L_k the enclosed volume; the
/// zones sum to the enclosed volume exactly.
struct VolumeZones {
  struct Cut {
    struct Part {
      int triangle;
      double before;  ///< before_c(t), 0 < before <= 1
    };
    struct Share {
      int node;
      double centre;  ///< centre_c(i); all sum to 1
    };
    std::vector<Part> parts;
    std::vector<Share> section;
  };
  std::vector<Cut> cuts;  ///< k - 1
  /// m^3: L_c of each cut at rest, then the enclosed volume; empty: one zone.
  std::vector<double> rest_before;

  int count() const { return static_cast<int>(rest_before.size()); }
};

/// Divides a body into `count` zones of equal length by the axis coordinates `along` (0..1) of its
/// nodes. Throws std::invalid_argument if a section has no node or a zone has no volume at rest.
VolumeZones make_volume_zones(const TriMesh& rest, const std::vector<double>& along, int count);

/// Coordinates 0..1 of the nodes along the longest axis of a body, the direction in which they vary
/// most.
std::vector<double> longest_axis_coordinates(const TriMesh& mesh);

/// L_c (m^3) of each cut, then the enclosed volume.
void volumes_before(const VolumeZones& zones, const Points& x,
                    const std::vector<Triangle>& triangles, std::vector<double>& before);
/// Derivatives of these volumes (m^2), one row for each node.
void gradients_before(const VolumeZones& zones, const Points& x,
                      const std::vector<Triangle>& triangles, std::vector<Points>& gradients);

/// Largest error of the volume of a zone, relative to its volume at rest. `before` and `wanted` are
/// volumes before the cuts (m^3).
double zone_error(const VolumeZones& zones, const std::vector<double>& before,
                  const std::vector<double>& wanted);

/// Scratch of restore_zones, kept so that a step does not allocate.
struct ZoneScratch {
  std::vector<double> before;
  std::vector<Points> gradients;
  Points start;
};
/// Moves x along `directions`, one for each cut and one for the whole body, until the volumes
/// before the cuts are `wanted` (m^3), by Newton's method on the k x k system. If that does not
/// converge, x is unchanged and the result is false: no motion along the directions changes a zone
/// that is wrong, or no such shape is near.
bool restore_zones(const VolumeZones& zones, const std::vector<Triangle>& triangles,
                   const std::vector<double>& wanted, const std::vector<Points>& directions,
                   ZoneScratch& scratch, Points& x);

}  // namespace thew::muscles
