// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/cache/cache.h"

namespace thew::tools {

/// How far from a muscle's first or last vertex its tendon may enter its bone, by the edge of a
/// cube of the muscle's volume at rest: so it goes by size. Of the arm's twelve it is 9 to 21
/// mm.
inline constexpr double kAttachmentReach = 0.4;

/// What two layers have of each other in one frame. Meshes are indices of BakeInfo::meshes.
struct Crossings {
  int pairs = 0;     ///< pairs of triangles with a common point
  int attached = 0;  ///< those of bone and muscle at attachments, not in `pairs`
  int mesh_a = -1, triangle_a = -1, mesh_b = -1, triangle_b = -1;  ///< the first of `pairs`
  Vec3 at = Vec3::Zero();                                          ///< a corner of triangle_a (m)
  double depth = 0.0;  ///< of the deepest vertex (m); between two meshes only
  int deep_mesh = -1, deep_vertex = -1, deep_in = -1;  ///< which vertex, in (skin: out of) which
  Vec3 deep_at = Vec3::Zero();
};

/// In the order of the names; props count as bones, and bone against bone and skin against prop
/// are left out.
inline constexpr std::array<const char*, 5> kLayerPairs = {
    "bone and muscle", "muscle and muscle", "skin and muscle", "skin and bone", "skin and skin"};

/// By exact tests of its own, which share nothing with the solver's contact. Triangles of one mesh
/// that share a vertex, or two at one place at rest, are left out. Depth is measured against closed
/// meshes, and against a skin with few holes.
std::array<Crossings, kLayerPairs.size()> find_crossings(
    const std::vector<BakeMesh>& meshes, const std::vector<std::vector<Vec3>>& positions);

/// The same without depths.
std::array<Crossings, kLayerPairs.size()> count_crossings(
    const std::vector<BakeMesh>& meshes, const std::vector<std::vector<Vec3>>& positions);

/// Pairs of triangles of a mesh that have a common point and no common vertex.
struct SelfCrossings {
  int pairs = 0;
  bool all = true;              ///< false: there may be more, looking for them was given up
  int first = -1, second = -1;  ///< triangles of the first pair
  Vec3 at = Vec3::Zero();       ///< where they cross (m)
};
/// Of a mesh whose vertices are finite and welded.
SelfCrossings find_self_crossings(const TriMesh& mesh);

/// Whether p is inside a closed mesh, by a ray's exact crossings.
bool is_inside(const Vec3& p, const std::vector<Vec3>& vertices,
               const std::vector<Triangle>& triangles);

}  // namespace thew::tools
