// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/mesh.h"
#include "tools/author/curve.h"
#include "tools/author/table.h"

namespace thew::tools {

/// One ring of a muscle's mesh: a section, star-shaped about its centre, in the plane across the
/// path.
struct Section {
  CurvePoint on_path;
  Vec3 wanted = Vec3::Zero();  ///< where the centre would be if it were free
  Vec3 centre = Vec3::Zero();
  double area = 0.0;    ///< m^2, wanted
  double radius = 0.0;  ///< m, how far it reaches where nothing is in its way
  bool belly = false;
  std::vector<double> reach;  ///< m, in each direction
  std::vector<double> limit;  ///< m, most that `reach` may be
  std::vector<double> angle;  ///< of the directions, growing, the first 0
  std::vector<Vec3> directions;
};

struct SectionedMuscle {
  Vec3 origin, insertion;  ///< the poles
  int origin_body = 0, insertion_body = 0;
  double tendon_radius[2];
  double flat = 1.0;
  Vec3 flat_along = Vec3::UnitY();
  int around = 0;
  double volume = 0.0;  ///< m^3, wanted
  double fill = 1.0;    ///< by which areas are to exceed `area` for the mesh to hold it
  std::vector<Section> sections;
};

/// Places the rings along the path and shares the volume out among them: a spindle.
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
/// The same with all sections scaled about their centres so that it encloses the wanted volume.
TriMesh exact_mesh_of(const SectionedMuscle& muscle);

}  // namespace thew::tools
