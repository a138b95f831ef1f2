// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"
#include "tools/author/curve.h"
#include "tools/author/table.h"

namespace thew::tools {

/// A section where nothing is in its way: what lies within `radius` of a line of `half` to both
/// sides of its middle.
struct Slab {
  double half = 0.0, radius = 0.0;  ///< m
  Vec3 along = Vec3::UnitZ();       ///< unit vector
};

/// m from the slab about `centre`, negative inside.
double slab_distance(const Slab& slab, const Vec3& centre, const Vec3& p);
/// m from its middle to its border in the direction of a unit vector.
double slab_reach(const Slab& slab, const Vec3& direction);

/// One ring of a muscle's mesh: a section, star-shaped about its centre, in the plane across the
/// path.
struct Section {
  CurvePoint on_path;
  Vec3 wanted = Vec3::Zero();  ///< where the centre would be if it were free
  Vec3 centre = Vec3::Zero();
  double area = 0.0;  ///< m^2, wanted
  Slab slab;          ///< of this area
  double grow = 1.0;  ///< by which the slab is thicker, for what neighbours take of it
  bool belly = false;
  std::vector<double> reach;  ///< m, in each direction
  std::vector<double> limit;  ///< m, most that `reach` may be
  std::vector<double> angle;  ///< of the directions, growing, the first 0
  std::vector<Vec3> directions;
};

/// The section's slab as it has grown: thicker, not wider.
Slab grown(const Section& section);

struct SectionedMuscle {
  Vec3 origin, insertion;  ///< the poles
  int origin_body = 0, insertion_body = 0;
  double tendon_radius[2];
  int around = 0;
  double volume = 0.0;  ///< m^3, wanted
  double fill = 1.0;    ///< by which areas are to exceed `area` for the mesh to hold it
  std::vector<Section> sections;
};

/// Places the rings along the path and shares the volume out among them as the table's sections do.
SectionedMuscle make_sections(const TableMuscle& muscle, const Pose& rest, const Vec3& humerus);

/// Spreads the directions so that the ring's nodes stand more evenly.
void even_out(Section& section);
void set_directions(Section& section);
double area_of(const Section& section);
Vec3 centroid_of(const Section& section);

/// Triangles of a tube (a pole, rings, a pole) in which each node is first named in the order of
/// its number, so that a reader that splits and welds corners keeps the order.
std::vector<Triangle> ordered_tube(int around, int rings);

/// The tube through the sections.
TriMesh mesh_of(const SectionedMuscle& muscle);
/// The same with the sections inside the belly scaled about their centres so that it encloses the
/// wanted volume.
TriMesh exact_mesh_of(const SectionedMuscle& muscle);

}  // namespace thew::tools
