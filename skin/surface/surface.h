// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/types.h"

namespace thew::skin {

/// Topology of a closed surface, which does not change while its nodes move.
struct Surface {
  std::vector<Triangle> triangles;
  std::vector<std::array<int, 3>> neighbours;  ///< triangle across each edge (k, k+1); -1: none
  std::vector<std::vector<int>> vertex_triangles;
  bool convex = false;  ///< convex, and rigid so that it stays convex
};
Surface make_surface(std::vector<Triangle> triangles, int nodes);
/// Whether no node lies outside the plane of a face by more than rounding.
bool is_convex(const Surface& surface, const Points& x);

/// Generalised winding number of the surface around p: about 1 inside, 0 outside, between them for
/// a surface with holes.
double winding_number(const Surface& surface, const Points& x, const Vec3& p);

/// Outward unit normal of a triangle (zero if it has no area), and of a node (mean of its
/// triangles, weighted by their angles at the node).
Vec3 face_normal(const Surface& surface, const Points& x, int triangle);
Vec3 node_normal(const Surface& surface, const Points& x, int node);

/// Axis-aligned box of nodes, for the broad phase. The default is everywhere.
struct NodeBox {
  Point low = Point{-1e300, -1e300, -1e300, 0.0}, high = -low;  ///< everywhere
};
/// A box that contains nothing.
inline NodeBox empty_box() {
  NodeBox box;
  std::swap(box.low, box.high);
  return box;
}
[[gnu::always_inline]] inline void grow(NodeBox& box, const Point& low, const Point& high) {
  box.low = low < box.low ? low : box.low;
  box.high = high > box.high ? high : box.high;
}
NodeBox box_of(const Points& x);
int longest_axis(const Point& extent);
/// Whether the boxes come within `reach` (m) of each other along each axis.
bool are_near(const NodeBox& a, const NodeBox& b, double reach);

/// Tree of boxes over the triangles of a surface: built once at rest by the surface area heuristic,
/// then refitted.
struct Bvh {
  struct Node {
    float lo[3], hi[3];  ///< rounded outwards
    int first, count;  ///< count > 0: a leaf over order[first, first + count); else children first,
                       ///< first + 1
  };
  std::vector<Node> nodes;
  std::vector<int> order;
};
Bvh build_bvh(const Surface& surface, const Points& x);
void refit_bvh(const Surface& surface, const Points& x, Bvh& bvh);
/// Distance (m) of a point from the box of the whole tree; 0 inside. The tree must not be empty.
double box_distance(const Bvh& bvh, const Point& p);

/// The nearest point of a surface. The sign of `distance` follows from the angle-weighted
/// pseudonormal of the face, edge or node (Baerentzen and Aanaes 2005).
struct ClosestPoint {
  int triangle = -1;  ///< -1: no point within the bound
  double barycentric[3] = {0, 0, 0};
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< outward unit pseudonormal at the point
  double distance = 0.0;        ///< m, negative inside
};
/// Searches within `bound` (m) of p. `hint` is a triangle to start from, or -1; it does not change
/// the result.
ClosestPoint closest_point(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                           double bound, int hint = -1);

/// Triangles of leaves whose boxes come within `reach` (m) of p, in an order that is always the
/// same.
void triangles_near(const Bvh& bvh, const Vec3& p, double reach, std::vector<int>& triangles);
/// The nearest point of one triangle, with the normal of the face.
ClosestPoint closest_on_triangle(const Surface& surface, const Points& x, int triangle,
                                 const Vec3& p);

/// Pairs (i, j) of triangles of a and b that cross properly, with i < j for a surface with itself,
/// where triangles that share a vertex are left out.
std::vector<std::array<int, 2>> crossing_triangles(const Surface& a, const Bvh& bvh_a,
                                                   const Points& xa, const Surface& b,
                                                   const Bvh& bvh_b, const Points& xb);
/// The same, into memory of the caller.
void find_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                    const Bvh& bvh_b, const Points& xb, std::vector<std::array<int, 2>>& pairs);
/// The same with pairs that may not cross, in no order that means anything: the triangles of all
/// other pairs are apart, whatever rounding does.
void find_near_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                         const Bvh& bvh_b, const Points& xb,
                         std::vector<std::array<int, 2>>& pairs);
/// Whether triangle pair[0] of a and pair[1] of b cross.
bool are_crossing(const Surface& a, const Points& xa, const Surface& b, const Points& xb,
                  const std::array<int, 2>& pair);

}  // namespace thew::skin
