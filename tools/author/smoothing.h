// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/surface/surface.h"
#include "tools/author/sections.h"

namespace thew::tools {

inline constexpr double kGap = 0.0008;  ///< m, kept between surfaces

/// How deep a tendon may enter a bone: only where it is attached to it. Bellies never do: contact
/// would press them out again.
double allowed_depth(const SectionedMuscle& muscle, bool belly, int body, const Vec3& p);

/// A mesh and its tree, to measure distances to.
struct Measured {
  TriMesh mesh;
  Surface surface;
  Points x;
  Bvh bvh;
  std::vector<std::array<int, 2>> edges;
  explicit Measured(TriMesh m);
};

/// Draws back what sticks out where two triangles meet too sharply, in the pose that the nodes
/// show.
void blunt(const Measured& mine, const std::vector<Vec3>& nodes, SectionedMuscle& muscle);

/// The sections part the muscles at their nodes; between nodes triangles still cut corners. Draws
/// back the nodes (and the corners of the triangles) that come closer than the gap.
void draw_back(const Measured& other, bool is_bone, int body, const Measured& mine,
               SectionedMuscle& muscle);

}  // namespace thew::tools
