// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/author/sections.h"

namespace thew::tools {

/// Where a section's plane lies in another pose: p -> point + linear (p - at), offsets from the
/// path swollen by `swell` (what the belly shortens).
struct PosedSection {
  Vec3 at, point;
  Mat3 linear;
  double swell = 1.0;
};

/// What the packing needs to know of one bent pose, all in the humerus' frame.
struct PackingPose {
  std::vector<Transform> bend;                      ///< by body: its motion from rest
  std::vector<std::vector<PosedSection>> sections;  ///< by muscle
  std::vector<SectionedMuscle> muscles;             ///< centres and radii there
};

/// The sections as the solver will carry them (muscles/carried_shape) with the elbow at `elbow`
/// rad.
PackingPose make_packing_pose(const std::vector<TableMuscle>& table,
                              const std::vector<SectionedMuscle>& muscles, const Skeleton& skeleton,
                              double elbow);

/// Where the solver will carry the nodes of a muscle's mesh, in the humerus' frame like the mesh.
std::vector<Vec3> carried_nodes(const TableMuscle& muscle, TriMesh mesh, const Skeleton& skeleton,
                                double elbow);

Vec3 posed(const PosedSection& section, const Vec3& p);

/// Moves the pose's copy of muscle m to where its sections are now.
void follow(const SectionedMuscle& muscle, size_t m, PackingPose& pose);

}  // namespace thew::tools
