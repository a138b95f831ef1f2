// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "skin/contact/contact.h"

namespace thew::skin {

/// What lies below the skin as one smooth field f over the distances d_j to each surface:
///   sum_j max(R + f - d_j, 0)^2 = R^2
/// Near a single surface f is its distance. Between two it is less, so that a level of f bridges a
/// crevice instead of diving into it, and its gradient there points out of the crevice. R is the
/// bridging radius (m).
struct FleshPlanes {
  static constexpr int kMost = 8;  ///< surfaces near one node
  struct Plane {
    Vec3 normal;    ///< out of the surface
    double offset;  ///< d_j(x) = normal . x - offset, near where it was looked up
  };
  std::vector<std::array<Plane, kMost>> planes;
  std::vector<int> count;
};

struct FleshValue {
  bool found = false;                     ///< false: no surface within reach
  double level = 0.0;                     ///< f, m
  double nearest = 0.0;                   ///< least d_j, m
  Vec3 gradient_of_level = Vec3::Zero();  ///< weighted mean of the normals; short in a crevice
  Vec3 normal_of_nearest = Vec3::Zero();
};

/// Looks up the planes of one node at p: surfaces within `reach` (m) that can matter to f there, by
/// the nearest and what is no farther than the bridging radius beyond it, on either side. Nearer
/// than `touching` (m) a distance tells no direction. `hints` only speed it up; by node, one for
/// each surface and one more, -1 at first.
void find_flesh(const std::vector<Collider>& below, const Vec3& p, double reach, double bridging,
                double touching, int node, std::vector<int>& hints, FleshPlanes& planes);

/// f at x by the node's planes.
FleshValue flesh_value(const FleshPlanes& planes, int node, const Vec3& x, double bridging);

}  // namespace thew::skin
